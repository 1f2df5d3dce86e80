// Draws a posed mesh as lit triangles or as a wireframe.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "apps/viewer/surface_buffer.h"
#include "splat/device/buffer.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat::viewer {

struct MeshPaint {
  std::vector<Rgb> faces;   // [F]
  bool edges_only = false;  // edges over dark faces, so that hidden edges stay hidden
};

// vertices: [V, 3] world units; paint.faces has one colour per face. Faces that reach behind the
// camera are omitted.
void DrawMesh(const std::vector<float>& vertices,
              const std::vector<std::array<int32_t, 3>>& faces,
              const MeshPaint& paint,
              const Camera& camera,
              SurfaceBuffer& buffer);

// Number of Gaussians on each of `faces` faces. triangle: [N].
std::vector<int> CountPerFace(cosplat::View<const int32_t> triangle, size_t faces);
std::vector<Rgb> CountColors(const std::vector<int>& counts);

// Draws Gaussians as lit one-standard-deviation ellipsoids in their mean colour. Shows positions
// and orientations, which alpha blending hides.
//
// Omitted are Gaussians with an opacity below 0.1, which are hardly visible when blended,
// non-finite ones, and those that reach behind the camera.
void DrawEllipsoids(const WorldGaussians& gaussians, const Camera& camera, SurfaceBuffer& buffer);

}  // namespace cosplat::viewer

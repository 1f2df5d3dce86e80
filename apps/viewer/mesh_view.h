// A posed mesh as lit triangles or as a wire.
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
  bool edges_only = false;  // edges over dark faces, so that what is behind stays hidden
};

// vertices: [V, 3] world units; paint.faces has a colour per face. Faces that reach behind the
// camera are left out.
void DrawMesh(const std::vector<float>& vertices,
              const std::vector<std::array<int32_t, 3>>& faces,
              const MeshPaint& paint,
              const Camera& camera,
              SurfaceBuffer& buffer);

// How many Gaussians each of `faces` faces has. triangle: [N].
std::vector<int> CountPerFace(View<const int32_t> triangle, size_t faces);
std::vector<Rgb> CountColors(const std::vector<int>& counts);

// Gaussians as the surfaces at one standard deviation, lit, each in its mean colour: shows where
// they are and how they lie, which their soft blend hides.

// Left out: those fainter than a tenth, which the blend hardly shows, those that are not finite,
// and those that reach behind the camera.
void DrawEllipsoids(const WorldGaussians& gaussians, const Camera& camera, SurfaceBuffer& buffer);

}  // namespace cosplat::viewer

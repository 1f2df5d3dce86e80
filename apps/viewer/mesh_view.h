// A posed mesh as lit triangles or as a wire.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "apps/viewer/surface_buffer.h"
#include "splat/device/buffer.h"

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

}  // namespace cosplat::viewer

// A small triangle rasteriser: exact pinhole camera, z-buffer, perspective-correct barycentrics.
//
// Coverage is sampled 4x4 times per pixel; colour is shaded per 2x2 quadrant and triangle, and
// averaged over the covered samples, so alpha is the covered share (straight alpha). Rows are
// rendered in parallel; the image has the same bits for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat::procedural {

// A point of a triangle that the camera sees.
struct SurfacePoint {
  int face = 0;
  std::array<float, 3> barycentrics{};  // perspective-correct, sum 1
  bool back = false;                    // seen from inside
};

class Shader {
 public:
  virtual ~Shader() = default;
  // Display-referred RGB, [0, 1]. Called from several threads.
  virtual std::array<float, 3> Shade(const SurfacePoint& point) const = 0;
};

// vertices: [V, 3] world units. Triangles that reach closer than 1e-3 to the camera are left out.
// Returns RGBA; colour where nothing is seen is white under alpha 0.
Image8 Rasterize(const std::vector<float>& vertices,
                 const std::vector<std::array<int32_t, 3>>& faces,
                 const Camera& camera,
                 const Shader& shader);

}  // namespace cosplat::procedural

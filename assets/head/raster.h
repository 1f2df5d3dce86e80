// A small triangle rasteriser: exact pinhole camera, z-buffer, perspective-correct barycentrics.
//
// Coverage is sampled 4x4 times per pixel. Colour is shaded once per 2x2 quadrant and triangle and
// averaged over the covered samples; alpha is the covered share (straight alpha). Rows are rendered
// in parallel; the image is bit-identical for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat::procedural {

// A visible point of a triangle.
struct SurfacePoint {
  int face = 0;
  std::array<float, 3> barycentrics{};  // perspective-correct, sum 1
  bool back = false;                    // seen from inside
};

class Shader {
 public:
  virtual ~Shader() = default;
  // Returns display-referred RGB, [0, 1]. Must be thread-safe.
  virtual std::array<float, 3> Shade(const SurfacePoint& point) const = 0;
};

// vertices: [V, 3] world units. Triangles closer than 1e-3 to the camera are omitted. Returns RGBA;
// empty pixels are white with alpha 0.
Image8 Rasterize(const std::vector<float>& vertices,
                 const std::vector<std::array<int32_t, 3>>& faces,
                 const Camera& camera,
                 const Shader& shader);

}  // namespace cosplat::procedural

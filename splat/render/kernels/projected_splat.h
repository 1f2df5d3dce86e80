// What the blend loop needs to know of one Gaussian: written by ProjectKernel, read per tile. A
// separate array, radii [count], holds 3 standard deviations along the longer axis in px, or 0 for
// invisible Gaussians, whose splats are unspecified.
#pragma once

#include "splat/math/namespace.h"

namespace cosplat {

// 64 bytes: one cache line. Lengths in px, pixel centres at +0.5. The first twelve are what
// blending needs, in the order in which it does: a device loads them by fours
// (splat/render/cuda/blend.cuh).
struct alignas(64) ProjectedSplat {
  float x, y;                          // centre
  float power_xx, power_xy, power_yy;  // exponent's quadratic form (math/blend.h)
  float reject_below;                  // exponent below which alpha < kMinAlpha
  float x_per_y, y_per_x;              // PowerRidges of the exponent (math/blend.h)
  float opacity;                       // [0, 1]
  float r, g, b;                       // colour along the view direction, >= 0
  float half_x, half_y;                // half-extents of the ellipse where alpha >= kMinAlpha
  float depth;                         // along the camera's axis, world units
  float padding;
};
constexpr int kProjectedFloats = 15;  // without the padding
constexpr int kProjectedStride = sizeof(ProjectedSplat) / sizeof(float);

// dL/d of these members, summed over the pixels of one tile or of all tiles.
struct SplatGradient {
  float x, y;
  float power_xx, power_xy, power_yy;
  float opacity;
  float r, g, b;

  COSPLAT_HD SplatGradient& operator+=(const SplatGradient& d) {
    x += d.x;
    y += d.y;
    power_xx += d.power_xx;
    power_xy += d.power_xy;
    power_yy += d.power_yy;
    opacity += d.opacity;
    r += d.r;
    g += d.g;
    b += d.b;
    return *this;
  }
};

}  // namespace cosplat

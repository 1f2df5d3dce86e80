// Structural similarity as its paper writes it, in floats: variances as E[x^2] - E[x]^2 and not
// clamped, and standard deviations taken of them. Source: Wang et al. 2004, eq. 6, 9, 10, 14-16.
#pragma once

#include <cmath>

#include "splat/math/ssim.h"

namespace cosplat {

// Of a window that holds x[i] and y[i] with these weights (of sum 1).
inline float NaiveSsim(const float* weights, const float* x, const float* y, int count) {
  float mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
  for (int i = 0; i < count; ++i) {
    mx += weights[i] * x[i];
    my += weights[i] * y[i];
    xx += weights[i] * x[i] * x[i];
    yy += weights[i] * y[i] * y[i];
    xy += weights[i] * x[i] * y[i];
  }
  const float sx = std::sqrt(xx - mx * mx), sy = std::sqrt(yy - my * my);
  const float covariance = xy - mx * my;
  const float luminance = (2 * mx * my + math::kSsimC1) / (mx * mx + my * my + math::kSsimC1);
  const float contrast = (2 * sx * sy + math::kSsimC2) / (sx * sx + sy * sy + math::kSsimC2);
  const float structure = (covariance + math::kSsimC2 / 2) / (sx * sy + math::kSsimC2 / 2);
  return luminance * contrast * structure;
}

}  // namespace cosplat

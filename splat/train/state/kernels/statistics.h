// Statistics of a step for density control, one Gaussian at a time. Shared by both back ends.
// Source: Kerbl et al. 2023, section 5.
#pragma once

#include <cmath>
#include <cstdint>

#include "splat/device/buffer.h"

namespace cosplat {
namespace math {

// What a step contributes to the statistics of a visible Gaussian.
struct ShapeOfStep {
  float screen = 0;      // |dL/d(centre)| in normalised device coordinates
  float plasticity = 0;  // |dL/ds|, s the three standard deviations
  // Steps with a non-finite gradient are not counted (Adam ignores such gradients, too).
  COSPLAT_HD bool IsUsable() const { return std::isfinite(screen) && std::isfinite(plasticity); }
};

// screen: [2] dL/d(centre) per px. d_scale_log, scale_log: [3].
COSPLAT_HD ShapeOfStep ShapeOf(
    const float* screen, const float* d_scale_log, const float* scale_log, int width, int height) {
  const float gx = screen[0] * 0.5f * width, gy = screen[1] * 0.5f * height;
  float square = 0;
  for (int k = 0; k < 3; ++k) {
    const float s = std::exp(scale_log[k]);
    const float d = s > 0 ? d_scale_log[k] / s : 0.0f;  // dL/ds; 0 if s is 0
    square += d * d;
  }
  return {std::sqrt(gx * gx + gy * gy), std::sqrt(square)};
}

// A sum over steps divided by the number of steps in which the Gaussian was visible; 0 if there
// were none.
COSPLAT_HD float MeanWhereVisible(float sum, float visible) {
  return visible > 0 ? sum / visible : 0.0f;
}

}  // namespace math

// One call per Gaussian. Does nothing if *overflowed is not 0, since the step will be repeated.
struct AccumulateStep {
  View<const float> radii, screen, d_scale_log, scale_log;
  int width, height;
  View<float> screen_gradient, plasticity, visible;
  const uint32_t* overflowed;
  COSPLAT_HD void operator()(size_t i) const { Add(i, i); }
  // row: where the Gaussian's radius and gradients are.
  COSPLAT_HD void Add(size_t i, size_t row) const {
    if (!(radii[row] > 0) || *overflowed != 0) return;
    const math::ShapeOfStep step =
        math::ShapeOf(&screen[2 * row], &d_scale_log[3 * row], &scale_log[3 * i], width, height);
    if (!step.IsUsable()) return;
    screen_gradient[i] += step.screen;
    plasticity[i] += step.plasticity;
    visible[i] += 1;
  }
};

}  // namespace cosplat

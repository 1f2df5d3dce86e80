// The derivative of the light's coefficients (avatar/math/light.h), and an Adam step on them, in
// training (avatar/train/light_fit.h).
#pragma once

#include <cmath>

#include "avatar/surface/kernels/embed.h"
#include "splat/device/sum.h"
#include "splat/math/adam.h"

namespace cosplat {

constexpr size_t kLightNumbers = 3 * math::kLightTerms;

// dL/d(coefficients), or a part of it.
struct LightSum {
  double d[kLightNumbers] = {};
  COSPLAT_HD LightSum& operator+=(const LightSum& other) {
    for (size_t k = 0; k < kLightNumbers; ++k) d[k] += other.d[k];
    return *this;
  }
};

// Sums over a block of Gaussians, in order.
struct SumLight {
  static constexpr size_t kBlock = 256;
  EmbeddedArrays gaussians;
  View<const float> d_log_light;  // [N, 3]
  View<LightSum> sums;            // [blocks]
  COSPLAT_HD void operator()(size_t b) const {
    const size_t last = math::Min((b + 1) * kBlock, gaussians.count);
    float sum[kLightNumbers] = {};
    for (size_t i = b * kBlock; i < last; ++i) {
      const math::Rows row{i, 1};
      const auto terms =
          math::LightTermsAt(math::LoadEmbedInput<float>(gaussians, row), gaussians, row);
      const float* d = &d_log_light[3 * i];
      for (size_t k = 0; k < size_t(math::kLightTerms); ++k)
        for (size_t c = 0; c < 3; ++c) sum[3 * k + c] += terms.y[k] * d[c];
    }
    LightSum total;
    for (size_t k = 0; k < kLightNumbers; ++k) total.d[k] = double(sum[k]);
    sums[b] = total;
  }
};

// Runs as a single call.
struct AddUpLight {
  View<const LightSum> sums;  // of SumInTree
  View<float> gradient;       // [kLightNumbers]
  COSPLAT_HD void operator()(size_t) const {
    const LightSum sum = SumOfBlock(sums, 0);
    for (size_t k = 0; k < kLightNumbers; ++k) gradient[k] = float(sum.d[k]);
  }
};

struct LightState {
  float value[kLightNumbers];
  math::AdamMoments<kLightNumbers> adam;
};

// Runs as a single call.
struct AdvanceLight {
  View<const float> gradient;  // [kLightNumbers]
  float rate;                  // at the first step; falls to zero at the last
  uint32_t steps;
  LightState* state;
  const uint32_t* overflowed;  // if it is not 0, nothing changes; or null
  COSPLAT_HD void operator()(size_t) const {
    if (overflowed && *overflowed != 0) return;
    ++state->adam.step;
    const float left = math::Max(0.0f, 1 - float(state->adam.step) / float(steps));
    const math::AdamStep step = math::AdamStepAt(rate * left, state->adam.step);
    const float max = math::kMaxLight;
    for (size_t k = 0; k < kLightNumbers; ++k) {
      float& value = state->value[k];
      state->adam.Update(step, k, gradient[k], value);
      value = math::Clamp(value, -max, max);
    }
  }
};

}  // namespace cosplat

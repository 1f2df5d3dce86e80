// Masks that rules of pruning learn beside the Gaussians (splat/prune/), one Gaussian at a time.
// Both back ends learn by these.
#pragma once

#include <cmath>

#include "splat/base/rng.h"
#include "splat/math/scalar.h"

namespace cosplat::math {

// Compact-3DGS (Lee et al. 2024, section 4.1): a mask 1[sigma(mu) > 0.01] on opacity and scale,
// learned with a straight-through gradient; loss weight * mean sigma(mu).
constexpr float kMaskThreshold = 0.01f;
constexpr float kHiddenLogit = -100;  // of an opacity

COSPLAT_HD bool MaskHides(float mu) { return Sigmoid(mu) <= kMaskThreshold; }

// dL/dmu, given the Gaussian's gradients where it was drawn. With the mask m = 1: d_m = dL/ds . s +
// dL/do o, the derivatives by log s and logit o being at hand. What is hidden was not drawn and has
// none. share: weight / how many there are.
COSPLAT_HD float HardMaskVjp(float mu,
                             float share,
                             bool drawn,
                             const float* d_scale_log,
                             float d_opacity_logit,
                             float opacity_logit) {
  const float soft = Sigmoid(mu);
  float d = share;
  if (drawn)  // 1 / (1 - o) = 1 + e^logit
    d += d_scale_log[0] + d_scale_log[1] + d_scale_log[2] +
         d_opacity_logit * (1 + std::exp(opacity_logit));
  return d * soft * (1 - soft);
}

// LP-3DGS (Zhang et al. 2024): a soft mask m = sigma((mu S + g1 - g2) / 0.5) dims an opacity o to
// m o, S an importance score, g Gumbel noise; loss weight * mean m.
constexpr float kMaskTemperature = 0.5f;
constexpr float kMinMask = 1e-6f;  // and of 1 - opacity: no division by zero
constexpr int kMaskDraws = 2;      // random numbers of a Gaussian

struct SoftMask {
  float mask, opacity_logit;  // m, and the logit of m o
};

COSPLAT_HD float Gumbel(Rng& rng) {
  return -std::log(-std::log(Clamp(rng.Uniform(), 1e-7f, 0.9999999f)));
}

COSPLAT_HD SoftMask SoftMaskOf(float mu, float importance, float opacity_logit, Rng& rng) {
  const float g1 = Gumbel(rng), g2 = Gumbel(rng);
  const float x = mu * importance + g1 - g2;
  const float mask = Max(Sigmoid(x / kMaskTemperature), float(kMinMask));
  const float dimmed = Min(mask * Sigmoid(opacity_logit), 1 - kMinMask);
  return {mask, std::log(dimmed / (1 - dimmed))};
}

// dL/dmu; d_opacity_logit, where the Gaussian was drawn, becomes dL/d(logit o) from dL/d(logit of
// o' = m o): d_m = d / (m (1 - o')), d_logit(o) = d (1 - o) / (1 - o').
COSPLAT_HD float SoftMaskVjp(const SoftMask& soft,
                             float importance,
                             float share,
                             bool drawn,
                             float opacity_logit,
                             float& d_opacity_logit) {
  const float m = soft.mask;
  float d_mask = share;
  if (drawn) {
    const float rest = Max(1 - Sigmoid(soft.opacity_logit), float(kMinMask));
    d_mask += d_opacity_logit / (m * rest);
    d_opacity_logit *= (1 - Sigmoid(opacity_logit)) / rest;
  }
  return d_mask * m * (1 - m) / kMaskTemperature * importance;
}

}  // namespace cosplat::math

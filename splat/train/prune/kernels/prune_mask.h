// Masks that pruning rules (splat/train/prune/) learn together with the Gaussians, one Gaussian at
// a time. Shared by both back ends.
#pragma once

#include <cmath>

#include "splat/base/rng.h"
#include "splat/device/buffer.h"
#include "splat/device/sum.h"
#include "splat/math/adam.h"
#include "splat/math/scalar.h"

namespace cosplat::math {

// Compact-3DGS (Lee et al. 2024, section 4.1): a mask 1[sigma(mu) > 0.01] on opacity and scale,
// learned with a straight-through gradient; loss weight * mean sigma(mu).
constexpr float kMaskThreshold = 0.01f;
constexpr float kHiddenLogit = -100;  // opacity logit of a hidden Gaussian

COSPLAT_HD bool MaskHides(float mu) { return Sigmoid(mu) <= kMaskThreshold; }

// dL/dmu, from the Gaussian's gradients if it was visible. With the mask m = 1:
// d_m = dL/ds . s + dL/do o, computed from the derivatives with respect to log s and logit o. A
// hidden Gaussian was not rendered and has no gradients. share: weight / number of Gaussians.
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
constexpr float kMinMask = 1e-6f;  // also of 1 - opacity: avoids division by zero
constexpr int kMaskDraws = 2;      // random numbers per Gaussian

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

// Returns dL/dmu. If the Gaussian was visible, converts d = d_opacity_logit from dL/d(logit o'),
// where o' = m o, to dL/d(logit o):
//   d_m = d / (m (1 - o')), d_logit(o) = d (1 - o) / (1 - o').
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

namespace cosplat {

enum class MaskKind { kHard, kSoft };

// The kernels of MaskLearner (splat/train/prune/mask_learner.h), one call per Gaussian:

struct HideMasked {
  View<const float> mu, opacity_logit;
  View<float> shown, drawn_logit;
  COSPLAT_HD void operator()(size_t i) const {
    shown[i] = math::Sigmoid(mu[i]);
    drawn_logit[i] = math::MaskHides(mu[i]) ? math::kHiddenLogit : opacity_logit[i];
  }
};

struct DimMasked {
  View<const float> mu, importance, opacity_logit;
  Rng rng;
  View<float> shown, drawn_logit;
  COSPLAT_HD void operator()(size_t i) const {
    Rng mine = rng.After(i * math::kMaskDraws);
    const math::SoftMask soft = math::SoftMaskOf(mu[i], importance[i], opacity_logit[i], mine);
    shown[i] = soft.mask;
    drawn_logit[i] = soft.opacity_logit;
  }
};

// One step of the mask's Adam.
struct LearnMask {
  MaskKind kind;
  float share;
  math::AdamStep adam;
  View<const float> radii, importance, shown, drawn_logit, opacity_logit, d_scale_log;
  const uint32_t* overflowed;
  View<float> d_opacity_logit, mu, m, v;
  COSPLAT_HD void operator()(size_t i) const {
    if (*overflowed != 0) return;
    math::AdamUpdate(adam, math::UsableGradient(Gradient(i)), mu[i], m[i], v[i]);
  }
  COSPLAT_HD float Gradient(size_t i) const {
    const bool drawn = radii[i] > 0;
    if (kind == MaskKind::kHard)
      return math::HardMaskVjp(
          mu[i], share, drawn, &d_scale_log[3 * i], d_opacity_logit[i], opacity_logit[i]);
    return math::SoftMaskVjp({shown[i], drawn_logit[i]},
                             importance[i],
                             share,
                             drawn,
                             opacity_logit[i],
                             d_opacity_logit[i]);
  }
};

// Masks as SumInTree adds them (splat/device/sum_tree.h).
struct ShownMasks {
  View<const float> shown;
  COSPLAT_HD size_t size() const { return shown.count; }
  COSPLAT_HD double operator[](size_t i) const { return shown[i]; }
};

// Runs as a single call.
struct AddUpShown {
  View<const double> sums;  // of SumInTree
  float share;
  double* value;
  COSPLAT_HD void operator()(size_t) const { *value = SumOfBlock(sums, 0) * share; }
};

}  // namespace cosplat

// The Adam update of one parameter (Kingma & Ba 2015, algorithm 1), and the catch-up of lazy Adam
// over several steps without a gradient.
#if defined(COSPLAT_SPLAT_MATH_ADAM_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_ADAM_H_
#undef COSPLAT_SPLAT_MATH_ADAM_H_
#else
#define COSPLAT_SPLAT_MATH_ADAM_H_
#endif

#include <cmath>
#include <cstdint>

#include "splat/math/scalar.h"

COSPLAT_MATH_BEGIN

// Constants of a step: learning rate and eps with the bias corrections of step t folded in, so that
// rate * m_hat / (sqrt(v_hat) + eps) = step_size * m / (sqrt(v) + scaled_eps).
struct AdamStep {
  float beta1 = 0.9f;
  float beta2 = 0.999f;
  float step_size = 0;   // learning rate * sqrt(1 - beta2^t) / (1 - beta1^t)
  float scaled_eps = 0;  // eps * sqrt(1 - beta2^t)
};

constexpr double kAdamEps = 1e-15;  // 3DGS

// The constants of step t, counted from 1. `rate`: learning rate for a step of one view. A step of
// `batch` views replaces as many: the rate grows with the square root of their number, and the
// moments forget as they would in so many steps (Zhao et al. 2024, Grendel-GS, section 4.2).
COSPLAT_HD AdamStep AdamStepAt(float rate, double eps, int64_t t, int batch = 1) {
  AdamStep step;
  if (batch > 1) {
    step.beta1 = float(std::pow(double(step.beta1), double(batch)));
    step.beta2 = float(std::pow(double(step.beta2), double(batch)));
    rate *= std::sqrt(float(batch));
  }
  const double correction1 = 1 - std::pow(double(step.beta1), double(t));
  const double correction2 = std::sqrt(1 - std::pow(double(step.beta2), double(t)));
  step.step_size = float(rate * correction2 / correction1);
  step.scaled_eps = float(eps * correction2);
  return step;
}
COSPLAT_HD AdamStep AdamStepAt(float rate, int64_t t) { return AdamStepAt(rate, kAdamEps, t); }

// Whether a gradient and its square are finite; other gradients are treated as zero.
COSPLAT_HD bool IsUsableGradient(float gradient) { return Abs(gradient) < 1e18f; }

COSPLAT_HD float UsableGradient(float gradient) {
  return IsUsableGradient(gradient) ? gradient : 0;
}

// `rate_scale` multiplies the learning rate of this parameter, for arrays whose parameters have
// different units.
template <class T>
COSPLAT_HD void AdamUpdate(
    const AdamStep& step, T gradient, T& value, T& m, T& v, T rate_scale = T(1)) {
  m = T(step.beta1) * m + T(1 - step.beta1) * gradient;
  v = T(step.beta2) * v + T(1 - step.beta2) * gradient * gradient;
  value = value - rate_scale * T(step.step_size) * m / (Sqrt(v) + T(step.scaled_eps));
}

// The moments of a few numbers that take their steps together.
template <size_t N>
struct AdamMoments {
  float m[N], v[N];
  uint32_t step;  // taken so far
  COSPLAT_HD void Update(const AdamStep& at, size_t k, float gradient, float& value) {
    AdamUpdate(at, UsableGradient(gradient), value, m[k], v[k]);
  }
};

// The effect of k steps without a gradient on one parameter, applied at once (lazy Adam's
// catch-up): m and v decay, and the remaining momentum moves the value by
//   sum over j = 1 ... k of step_size beta1^j m / (sqrt(beta2^j v) + eps)
//     = step_size (r + r^2 + ... + r^k) m / sqrt(v),  r = beta1 / sqrt(beta2),
// with one step size for all k steps (that of the catch-up step) and without eps in the series.
struct AdamTail {
  float m_factor = 1, v_factor = 1;  // beta1^k, beta2^k
  float step_size = 0;               // times the sum of the powers of r
};
COSPLAT_HD AdamTail AdamTailOf(const AdamStep& step, int k) {
  const float m_factor = std::pow(step.beta1, float(k)), v_factor = std::pow(step.beta2, float(k));
  const float r = step.beta1 / std::sqrt(step.beta2);
  return {m_factor, v_factor, step.step_size * r * (1 - std::pow(r, float(k))) / (1 - r)};
}
template <class T>
COSPLAT_HD void AdamCatchUp(
    const AdamStep& step, const AdamTail& tail, T& value, T& m, T& v, T rate_scale = T(1)) {
  value = value - rate_scale * T(tail.step_size) * m / (Sqrt(v) + T(step.scaled_eps));
  m = T(tail.m_factor) * m;
  v = T(tail.v_factor) * v;
}

COSPLAT_MATH_END
#endif

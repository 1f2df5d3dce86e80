// One Adam update of one number (Kingma & Ba 2015, algorithm 1).
#if defined(COSPLAT_SPLAT_MATH_ADAM_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_ADAM_H_
#undef COSPLAT_SPLAT_MATH_ADAM_H_
#else
#define COSPLAT_SPLAT_MATH_ADAM_H_
#endif

#include "splat/math/scalar.h"

COSPLAT_MATH_BEGIN

// Constants of a step: rate and eps with the bias corrections of step t folded in, so that
// rate * m_hat / (sqrt(v_hat) + eps) = step_size * m / (sqrt(v) + scaled_eps).
struct AdamStep {
  float beta1 = 0.9f;
  float beta2 = 0.999f;
  float step_size = 0;   // rate * sqrt(1 - beta2^t) / (1 - beta1^t)
  float scaled_eps = 0;  // eps * sqrt(1 - beta2^t)
};

// `rate_scale` multiplies the rate of this one number: parameters of one array that are measured in
// different units.
template <class T>
COSPLAT_HD void AdamUpdate(
    const AdamStep& step, T gradient, T& value, T& m, T& v, T rate_scale = T(1)) {
  m = T(step.beta1) * m + T(1 - step.beta1) * gradient;
  v = T(step.beta2) * v + T(1 - step.beta2) * gradient * gradient;
  value = value - rate_scale * T(step.step_size) * m / (Sqrt(v) + T(step.scaled_eps));
}

COSPLAT_MATH_END
#endif

#include "splat/cpu/adam_range.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cpu/adam_range.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/adam.h"

COSPLAT_MATH_BEGIN

size_t UpdateRange(const AdamConstants& c,
                   size_t n,
                   const float* __restrict gradient,
                   float* __restrict value,
                   float* __restrict m,
                   float* __restrict v,
                   const float* __restrict rate_scale) {
  const AdamStep step{c.beta1, c.beta2, c.step_size, c.scaled_eps};
  unsigned bad = 0;
  for (size_t i = 0; i < n; ++i) {
    const bool finite = Abs(gradient[i]) < 1e18f;  // its square must be finite too
    bad += !finite;
    const float g = finite ? gradient[i] : 0.0f;
    AdamUpdate(step, g, value[i], m[i], v[i], rate_scale ? rate_scale[i] : 1.0f);
  }
  return bad;
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(UpdateRange);
}

size_t AdamRange(const AdamConstants& c,
                 size_t n,
                 const float* gradient,
                 float* value,
                 float* m,
                 float* v,
                 const float* rate_scale) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(UpdateRange)(c, n, gradient, value, m, v, rate_scale);
}

}  // namespace cosplat
#endif

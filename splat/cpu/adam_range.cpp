#include "splat/cpu/adam_range.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cpu/adam_range.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/adam.h"

COSPLAT_MATH_BEGIN

unsigned UpdateRange(const AdamStep& step,
                     size_t n,
                     const float* __restrict gradient,
                     float* __restrict value,
                     float* __restrict m,
                     float* __restrict v,
                     const float* __restrict rate_scale) {
  unsigned bad = 0;
  for (size_t i = 0; i < n; ++i) {
    const bool finite = Abs(gradient[i]) < 1e18f;  // its square must be finite too
    bad += !finite;
    const float g = finite ? gradient[i] : 0.0f;
    AdamUpdate(step, g, value[i], m[i], v[i], rate_scale ? rate_scale[i] : 1.0f);
  }
  return bad;
}

size_t UpdateRanges(const AdamArray& a, const GaussianRange* ranges, size_t count) {
  const AdamStep step{a.beta1, a.beta2, a.step_size, a.scaled_eps};
  size_t bad = 0;
  for (size_t r = 0; r < count; ++r) {
    const size_t at = size_t(ranges[r].begin) * a.width;
    bad += UpdateRange(step,
                       size_t(ranges[r].end - ranges[r].begin) * a.width,
                       a.gradient + at,
                       a.value + at,
                       a.m + at,
                       a.v + at,
                       a.rate_scale ? a.rate_scale + at : nullptr);
  }
  return bad;
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(UpdateRanges);
}

size_t AdamRanges(const AdamArray& array, const GaussianRange* ranges, size_t count) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(UpdateRanges)(array, ranges, count);
}

}  // namespace cosplat
#endif

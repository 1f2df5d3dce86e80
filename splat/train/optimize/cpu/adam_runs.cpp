#include "splat/train/optimize/cpu/adam_runs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/train/optimize/cpu/adam_runs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/math/adam.h"

COSPLAT_MATH_BEGIN

// One run's values of one attribute.
struct RunNumbers {
  size_t count;
  const float* gradient;
  float* value;
  float* m;
  float* v;
  const float* rate_scale;
};

void CatchUp(const AdamStep& step, int behind, const RunNumbers& run) {
  const AdamTail tail = AdamTailOf(step, behind);
  float* __restrict value = run.value, * __restrict m = run.m, * __restrict v = run.v;
  const float* __restrict scale = run.rate_scale;
  for (size_t i = 0; i < run.count; ++i)
    AdamCatchUp(step, tail, value[i], m[i], v[i], scale ? scale[i] : 1.0f);
}

unsigned Update(const AdamStep& step, const RunNumbers& run) {
  const float* __restrict gradient = run.gradient;
  float* __restrict value = run.value, * __restrict m = run.m, * __restrict v = run.v;
  const float* __restrict scale = run.rate_scale;
  unsigned bad = 0;
  for (size_t i = 0; i < run.count; ++i) {
    const bool usable = IsUsableGradient(gradient[i]);
    bad += !usable;
    const float g = usable ? gradient[i] : 0.0f;
    AdamUpdate(step, g, value[i], m[i], v[i], scale ? scale[i] : 1.0f);
  }
  return bad;
}

size_t UpdateRuns(const AdamArray& a, const AdamRun* runs, size_t count) {
  const AdamStep step{a.beta1, a.beta2, a.step_size, a.scaled_eps};
  size_t bad = 0;
  for (size_t r = 0; r < count; ++r) {
    const size_t at = size_t(runs[r].begin) * a.width;
    const RunNumbers run{size_t(runs[r].end - runs[r].begin) * a.width,
                         a.gradient ? a.gradient + at : nullptr,
                         a.value + at,
                         a.m + at,
                         a.v + at,
                         a.rate_scale ? a.rate_scale + at : nullptr};
    if (runs[r].behind > 0) CatchUp(step, runs[r].behind, run);
    if (run.gradient) bad += Update(step, run);
  }
  return bad;
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(UpdateRuns);
}

size_t AdamRuns(const AdamArray& array, const AdamRun* runs, size_t count) {
  using namespace math;
  return HWY_DYNAMIC_DISPATCH(UpdateRuns)(array, runs, count);
}

}  // namespace cosplat
#endif

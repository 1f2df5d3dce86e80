#include "splat/optimizer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "splat/cpu/adam_range.h"
#include "splat/math/adam.h"

namespace cosplat {

namespace {
constexpr size_t kRangesPerTask = 4;  // at least
}  // namespace

size_t AdamStepAll(const AdamSettings& settings,
                   const Gaussians& gradients,
                   View<const float> position_rate_scale,
                   View<const GaussianRange> ranges,
                   Gaussians& values,
                   AdamState& state) {
  ++state.step;
  const math::AdamStep defaults;
  const double correction1 = 1 - std::pow(double(defaults.beta1), double(state.step));
  const double correction2 = std::sqrt(1 - std::pow(double(defaults.beta2), double(state.step)));
  std::array<AdamArray, kAttributeCount> arrays;
  for (int a = 0; a < kAttributeCount; ++a) {
    arrays[a].width = values.width(a);
    arrays[a].beta1 = defaults.beta1;
    arrays[a].beta2 = defaults.beta2;
    arrays[a].step_size = float(settings.rate[a] * correction2 / correction1);
    arrays[a].scaled_eps = float(settings.eps[a] * correction2);
    arrays[a].gradient = gradients.values[a].data();
    arrays[a].value = values.values[a].data();
    arrays[a].m = state.m.values[a].data();
    arrays[a].v = state.v.values[a].data();
    arrays[a].rate_scale = a == kPosition ? position_rate_scale.data : nullptr;
  }
  std::atomic<size_t> bad{0};  // a count: the order of adding does not matter
  tbb::parallel_for(tbb::blocked_range<size_t>(0, ranges.size(), kRangesPerTask),
                    [&](const auto& task) {
                      for (const AdamArray& array : arrays)
                        bad += AdamRanges(array, ranges.data + task.begin(), task.size());
                    });
  return bad;
}

std::vector<GaussianRange> AllRanges(size_t n) {
  std::vector<GaussianRange> ranges;
  for (size_t i = 0; i < n; i += kLongestGaussianRange)
    ranges.push_back({uint32_t(i), uint32_t(std::min(i + kLongestGaussianRange, n))});
  return ranges;
}

}  // namespace cosplat

#include "splat/optimizer.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>

#include "splat/cpu/adam_range.h"
#include "splat/math/adam.h"

namespace cosplat {

size_t AdamStepAll(const AdamSettings& settings,
                   const Gaussians& gradients,
                   View<const float> position_rate_scale,
                   Gaussians& values,
                   AdamState& state) {
  ++state.step;
  const math::AdamStep defaults;
  const double correction1 = 1 - std::pow(double(defaults.beta1), double(state.step));
  const double correction2 = std::sqrt(1 - std::pow(double(defaults.beta2), double(state.step)));
  std::atomic<size_t> bad{0};  // a count: the order of adding does not matter
  for (int a = 0; a < kAttributeCount; ++a) {
    const AdamConstants constants{defaults.beta1,
                                  defaults.beta2,
                                  float(settings.rate[a] * correction2 / correction1),
                                  float(settings.eps[a] * correction2)};
    const float* rate_scale = a == kPosition ? position_rate_scale.data : nullptr;
    const size_t n = values.values[a].size();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, n, 16384), [&](const auto& r) {
      const size_t i = r.begin();
      bad += AdamRange(constants,
                       r.size(),
                       gradients.values[a].data() + i,
                       values.values[a].data() + i,
                       state.m.values[a].data() + i,
                       state.v.values[a].data() + i,
                       rate_scale ? rate_scale + i : nullptr);
    });
  }
  return bad;
}

}  // namespace cosplat

#include "splat/prune/learned_mask.h"

#include <cmath>

namespace cosplat {

math::AdamStep MaskAdamStep(float rate, int64_t step) {
  math::AdamStep adam;
  const double c1 = 1 - std::pow(double(adam.beta1), double(step));
  const double c2 = std::sqrt(1 - std::pow(double(adam.beta2), double(step)));
  constexpr double kEps = 1e-15;
  adam.step_size = float(rate * c2 / c1);
  adam.scaled_eps = float(kEps * c2);
  return adam;
}

void LearnedMask::Step(const std::vector<float>& gradient) {
  const math::AdamStep adam = MaskAdamStep(rate, ++step);
  for (size_t i = 0; i < value.size(); ++i)
    math::AdamUpdate(adam, std::isfinite(gradient[i]) ? gradient[i] : 0.0f, value[i], m[i], v[i]);
}

void LearnedMask::Gather(const Reordering& order) {
  for (std::vector<float>* numbers : {&value, &m, &v}) {
    std::vector<float> gathered(order.source.size());
    for (size_t i = 0; i < gathered.size(); ++i) gathered[i] = (*numbers)[order.source[i]];
    *numbers = std::move(gathered);
  }
  for (const uint32_t i : order.fresh) m[i] = v[i] = 0;
}

}  // namespace cosplat

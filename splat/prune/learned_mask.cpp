#include "splat/prune/learned_mask.h"

#include <cmath>

#include "splat/math/adam.h"

namespace cosplat {

void LearnedMask::Step(const std::vector<float>& gradient) {
  ++step_;
  math::AdamStep step;
  const double c1 = 1 - std::pow(double(step.beta1), double(step_));
  const double c2 = std::sqrt(1 - std::pow(double(step.beta2), double(step_)));
  constexpr double kEps = 1e-15;
  step.step_size = float(rate_ * c2 / c1);
  step.scaled_eps = float(kEps * c2);
  for (size_t i = 0; i < value_.size(); ++i)
    math::AdamUpdate(
        step, std::isfinite(gradient[i]) ? gradient[i] : 0.0f, value_[i], m_[i], v_[i]);
}

void LearnedMask::Gather(const Reordering& order) {
  for (std::vector<float>* numbers : {&value_, &m_, &v_}) {
    std::vector<float> gathered(order.source.size());
    for (size_t i = 0; i < gathered.size(); ++i) gathered[i] = (*numbers)[order.source[i]];
    *numbers = std::move(gathered);
  }
  for (const uint32_t i : order.fresh) m_[i] = v_[i] = 0;
}

}  // namespace cosplat

// A number per Gaussian that is trained beside it, from which a rule makes its mask.
#pragma once

#include <vector>

#include "splat/density.h"
#include "splat/memory_part.h"

namespace cosplat {

class LearnedMask {
 public:
  LearnedMask(size_t gaussians, float first, float rate)
      : rate_(rate), value_(gaussians, first), m_(gaussians, 0.0f), v_(gaussians, 0.0f) {}

  size_t size() const { return value_.size(); }
  size_t Held() const { return HeldBy(value_, m_, v_); }
  float operator[](size_t i) const { return value_[i]; }
  // One Adam step with these gradients; those that are not finite count as zero.
  void Step(const std::vector<float>& gradient);
  // New ones have their parent's number and no momentum.
  void Gather(const Reordering& order);

 private:
  float rate_;
  std::vector<float> value_, m_, v_;
  int64_t step_ = 0;
};

}  // namespace cosplat

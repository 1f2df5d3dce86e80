// How many instances the next drawing of a frame will have, so that nobody need wait to know.
//
// Too few cost the steps that have to be done again, too many are sorted for nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace cosplat {

class InstanceForecast {
 public:
  // margin: of what is expected, to be asked for.
  explicit InstanceForecast(double margin = kMargin) : margin_(margin) {}

  // Whether there is anything to go by.
  bool Knows() const { return most_ > 0; }
  // For so many Gaussians: as the frame had, or the fullest where it was not drawn yet.
  size_t Of(size_t frame, size_t gaussians) const {
    const double last = LastOf(frame);
    const double expected = last > 0 ? last * growth_ : most_;
    return size_t(margin_ * expected * double(gaussians)) + 1;
  }
  void Saw(size_t frame, size_t gaussians, size_t instances) {
    const double now = double(instances) / double(std::max<size_t>(gaussians, 1));
    const double last = LastOf(frame);
    growth_ = std::max(1 + kFade * (growth_ - 1), last > 0 ? now / last : 1.0);
    if (last_.size() <= frame) last_.resize(frame + 1, 0.0f);
    last_[frame] = float(now);
    most_ = std::max(most_, now);
  }

 private:
  // By the counts of two runs on the processor (fox and chair at -r 8, seed 0) 4 of 2,000 and 17 of
  // 3,000 steps have more than was predicted with this and the growth, most of them while opacities
  // rise after a reset; in all, the capacity is 1.16 and 1.34 times the instances.
  static constexpr double kMargin = 1.125;
  // What frames lately grew by since they were last drawn fades by half in 14 steps.
  static constexpr double kFade = 0.95;

  double LastOf(size_t frame) const { return frame < last_.size() ? double(last_[frame]) : 0.0; }

  double margin_;
  std::vector<float> last_;         // [frames] instances per Gaussian; 0: not drawn yet
  double most_ = 0, growth_ = 1.0;  // of last_: the most ever, and what it changes by at the most
};

}  // namespace cosplat

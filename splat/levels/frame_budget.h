// How many Gaussians may be drawn so that an image takes no longer than it should.
#pragma once

#include <algorithm>
#include <cstddef>

namespace cosplat {

class FrameBudget {
 public:
  // Limit for the next image.
  size_t most() const { return size_t(most_); }

  // Reports the image that was drawn last under this limit, and how long it was to take. Falls at
  // once; rises slowly, and only if the limit was what held the image back.
  void Drawn(size_t gaussians, double milliseconds, double aim) {
    if (milliseconds <= 0) return;
    const double possible = double(gaussians) * aim / milliseconds;
    if (milliseconds > aim) {
      most_ = std::max(possible, 0.5 * most_);
    } else if (double(gaussians) > kHeldBack * most_) {
      most_ = std::min(possible, kRise * most_);
    }
    most_ = std::clamp(most_, kLeast, kMost);
  }

 private:
  static constexpr double kFirst = 200000, kLeast = 20000, kMost = 1e9;
  static constexpr double kHeldBack = 0.9, kRise = 1.1;
  double most_ = kFirst;
};

}  // namespace cosplat

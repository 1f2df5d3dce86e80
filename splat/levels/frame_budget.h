// How many Gaussians may be drawn so that an image takes no longer than it should.
#pragma once

#include <algorithm>
#include <cstddef>

namespace cosplat {

class FrameBudget {
 public:
  // Limit for an image that may take this long.
  size_t Most(double milliseconds) const {
    return size_t(std::clamp(milliseconds / per_gaussian_, kLeast, kMost));
  }

  // Reports an image. A dearer one counts at once, a cheaper one little by little, so that single
  // images that happen to be fast do not make the next ones late.
  void Drawn(size_t gaussians, double milliseconds) {
    if (double(gaussians) < kLeast) return;  // of few Gaussians, pixels take the time
    per_gaussian_ = std::max(milliseconds / double(gaussians), kFall * per_gaussian_);
  }

 private:
  static constexpr double kLeast = 10000, kMost = 1e9;
  static constexpr double kFall = 0.9;
  double per_gaussian_ = 2e-4;  // ms; two cores' to begin with
};

}  // namespace cosplat

// How many Gaussians may be drawn so that an image takes no longer than it should.
#pragma once

#include <algorithm>
#include <cstddef>

namespace cosplat {

class FrameBudget {
 public:
  // milliseconds: aimed at for each of a series of images.
  explicit FrameBudget(double milliseconds) : milliseconds_(milliseconds) {}

  // Limit for the next image; at least kMin, however slow the machine is.
  size_t max() const { return size_t(std::clamp(milliseconds_ / per_gaussian_, kMin, kMax)); }

  // Reports an image. A dearer one counts at once, a cheaper one little by little, so that single
  // images that happen to be fast do not make the next ones late.
  void Drawn(size_t gaussians, double milliseconds) {
    if (double(gaussians) < 0.5 * kMin) return;  // of few Gaussians, pixels take the time
    const double cost = milliseconds / double(gaussians);
    per_gaussian_ = std::min(std::max(cost, kFall * per_gaussian_), milliseconds_ / kMin);
  }

 private:
  static constexpr double kMin = 50000, kMax = 1e9;
  static constexpr double kFall = 0.9;
  double milliseconds_;
  double per_gaussian_ = 2e-4;  // ms; two cores' to begin with
};

}  // namespace cosplat

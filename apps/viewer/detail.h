// Chooses the resolution while the user drags: the finest that keeps the frame rate up.
#pragma once

#include <array>
#include <cstddef>

namespace cosplat::viewer {

class Detail {
 public:
  // Reports the render time of an image with sides divided by `divisor`.
  void Drawn(int divisor, double milliseconds) {
    milliseconds_[divisor >= 4 ? 2 : divisor >= 2 ? 1 : 0] = milliseconds;
  }
  // 1, 2 or 4; always 1 when not dragging.
  int Divisor(bool dragging) const {
    if (!dragging) return 1;
    double last = 0;
    for (size_t i = 0; i + 1 < milliseconds_.size(); ++i) {
      last = milliseconds_[i] > 0 ? milliseconds_[i] : kGuessedShare * last;
      if (last <= kBudget) return 1 << i;
    }
    return 4;
  }

 private:
  static constexpr double kBudget = 50;  // ms; twenty images per second still follow the mouse
  // Estimated share of the time when the sides are halved, before it was measured: part of the work
  // (posing and sorting) does not depend on the number of pixels.
  static constexpr double kGuessedShare = 0.5;
  std::array<double, 3> milliseconds_{};  // of the last image by divisor; 0: none yet
};

}  // namespace cosplat::viewer

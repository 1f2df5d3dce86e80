// How finely to draw while somebody drags: as finely as keeps up.
#pragma once

#include <array>

namespace cosplat::viewer {

class Detail {
 public:
  // A picture with sides divided by `divisor` took so long.
  void Drawn(int divisor, double milliseconds);
  // 1, 2 or 4. At rest, always 1.
  int Divisor(bool dragging) const;

 private:
  std::array<double, 3> milliseconds_{};  // of the last picture by divisor; 0: none yet
};

}  // namespace cosplat::viewer

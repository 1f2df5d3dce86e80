// The robust loss of the track's residuals. Private to flame/fit/.
#pragma once

#include <cmath>

namespace cosplat::internal {

// In units of a residual's standard deviation: beyond it, errors count linearly.
constexpr double kRobustFrom = 2;

// Residuals r, alone or in pairs, become g r with s = |r|^2 and g^2 s = 2 c^2 (sqrt(1 + s / c^2) -
// 1), c = kRobustFrom, which grows as |r| far away (Charbonnier et al. 1997). Returns g(s);
// d_factor is its derivative.
inline double RobustFactor(double s, double& d_factor) {
  constexpr double c2 = kRobustFrom * kRobustFrom;
  const double q = std::sqrt(1 + s / c2);
  const double factor = std::sqrt(2 / (1 + q));
  d_factor = -factor / (4 * c2 * q * (1 + q));
  return factor;
}

}  // namespace cosplat::internal

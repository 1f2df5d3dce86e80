#include "splat/base/world_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "splat/base/median.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr double kSmall = 0.1;  // size below which a scene has small units
constexpr double kFar = 100;    // spreads

// Exact for decimals: below 1 a power of ten is only representable as a divisor.
double RoundedTo(double value, int exponent) {
  const double power = std::pow(10.0, std::abs(exponent));
  return exponent < 0 ? std::round(value * power) / power : std::round(value / power) * power;
}

}  // namespace

float SmallUnit(double size) {
  return size >= kSmall ? 1 : float(std::pow(10.0, std::floor(std::log10(size))));
}

WorldOrigin OriginNear(const std::array<double, 3>& center, double spread) {
  WorldOrigin origin{};
  if (!(spread > 0)) spread = 1;  // of a single place
  for (size_t k = 0; k < 3; ++k)
    if (std::abs(center[k]) > kFar * spread)
      origin[k] = RoundedTo(center[k], int(std::ceil(std::log10(spread))));
  return origin;
}

Middle MiddleOf(const std::vector<double>& points) {
  Middle middle;
  std::vector<double> values(points.size() / 3);
  for (size_t k = 0; k < 3; ++k) {
    for (size_t i = 0; i < values.size(); ++i) values[i] = points[3 * i + k];
    middle.center[k] = Median(values);
  }
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = 0;
    for (size_t k = 0; k < 3; ++k)
      values[i] = std::max(values[i], std::abs(points[3 * i + k] - middle.center[k]));
  }
  middle.spread = Median(values);
  return middle;
}

std::string ToString(const WorldOrigin& origin) {
  return Format("({:.15g}, {:.15g}, {:.15g})", origin[0], origin[1], origin[2]);
}

}  // namespace cosplat

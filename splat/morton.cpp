#include "splat/morton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cosplat {
namespace {

using Point = std::array<float, 3>;

constexpr int kBits = 21;  // per axis: three fit 64 bits

bool IsFinite(const Point& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

// Spreads the lowest 21 bits to every third place.
uint64_t Spread(uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<uint32_t> MortonOrder(const std::vector<Point>& points) {
  Point low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (const Point& p : points) {
    if (!IsFinite(p)) continue;
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  std::vector<std::pair<uint64_t, uint32_t>> codes(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    uint64_t code = std::numeric_limits<uint64_t>::max();
    if (IsFinite(points[i])) {
      code = 0;
      for (int k = 0; k < 3; ++k) {
        // In double: the box may be wider than a float's range, and 2^21 cells need 21 bits.
        const double share =
            (double(points[i][k]) - low[k]) / std::max(double(high[k]) - low[k], 1e-30);
        code |= Spread(uint64_t(share * ((1 << kBits) - 1))) << k;
      }
    }
    codes[i] = {code, uint32_t(i)};
  }
  std::sort(codes.begin(), codes.end());
  std::vector<uint32_t> order(points.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = codes[i].second;
  return order;
}

}  // namespace cosplat

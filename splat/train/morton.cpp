#include "splat/train/morton.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "splat/train/kernels/density.h"

namespace cosplat {
namespace {

using Point = std::array<float, 3>;

}  // namespace

std::vector<uint32_t> MortonOrder(const std::vector<Point>& points) {
  Point low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (const Point& p : points) {
    if (!math::IsFinitePoint(p.data())) continue;
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  std::vector<std::pair<uint64_t, uint32_t>> codes(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    codes[i] = {math::MortonCode(points[i].data(), low.data(), high.data()), uint32_t(i)};
  std::sort(codes.begin(), codes.end());
  std::vector<uint32_t> order(points.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = codes[i].second;
  return order;
}

}  // namespace cosplat

// The order along a Morton curve.
#include "splat/train/density/morton.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/base/rng.h"
#include "tests/support/morton_order.h"

namespace cosplat {
namespace {

using Points = std::vector<std::array<float, 3>>;

TEST(Morton, CornersOfABoxGoXThenYThenZ) {
  const Points points{
      {1, 1, 1}, {0, 1, 0}, {1, 0, 1}, {0, 0, 0}, {0, 1, 1}, {1, 0, 0}, {0, 0, 1}, {1, 1, 0}};
  EXPECT_EQ(MortonOrder(points), (std::vector<uint32_t>{3, 5, 1, 7, 6, 2, 4, 0}));
}

TEST(Morton, NeighboursInOrderAreNearInSpace) {
  Rng rng{1};
  Points points(4096);
  for (auto& p : points) p = {rng.Uniform(), rng.Uniform(), rng.Uniform()};
  const auto length = [&](const std::vector<uint32_t>& order) {
    double sum = 0;
    for (size_t i = 1; i < order.size(); ++i) {
      const auto &a = points[order[i - 1]], &b = points[order[i]];
      sum += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
    return sum / double(order.size() - 1);
  };
  std::vector<uint32_t> as_given(points.size());
  for (size_t i = 0; i < as_given.size(); ++i) as_given[i] = uint32_t(i);
  const std::vector<uint32_t> order = MortonOrder(points);
  // In a unit cube: 0.66 between random points, about 1.5 / 16 between neighbours on the curve.
  EXPECT_LT(length(order), length(as_given) / 5);
  std::vector<uint32_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, as_given);
}

TEST(Morton, DegeneratePoints) {
  EXPECT_TRUE(MortonOrder({}).empty());
  EXPECT_EQ(MortonOrder({{2, 2, 2}, {2, 2, 2}, {2, 2, 2}}), (std::vector<uint32_t>{0, 1, 2}));
  const float huge = std::numeric_limits<float>::max();
  EXPECT_EQ(MortonOrder({{NAN, 0, 0}, {huge, huge, huge}, {0, INFINITY, 0}, {-huge, -huge, -huge}}),
            (std::vector<uint32_t>{3, 1, 0, 2}));
}

}  // namespace
}  // namespace cosplat

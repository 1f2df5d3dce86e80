#include "splat/media/signed_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/base/rng.h"

namespace cosplat {
namespace {

// Against all pairs of pixels, exactly.
TEST(SignedDistance, IsToTheNearestPixelOnTheOtherSide) {
  Rng rng{3};
  for (const float share : {0.03f, 0.5f, 0.97f}) {
    Image8 mask(23, 17, 1);
    for (uint8_t& value : mask.data) value = rng.Uniform() < share ? 200 : 60;
    mask.data[5] = 200;
    mask.data[90] = 60;
    const Image distance = SignedDistance(mask, 128);
    for (int p = 0; p < 23 * 17; ++p) {
      int nearest = 1 << 30;
      for (int q = 0; q < 23 * 17; ++q) {
        const int dx = p % 23 - q % 23, dy = p / 23 - q / 23;
        if (mask.data[size_t(p)] != mask.data[size_t(q)])
          nearest = std::min(nearest, dx * dx + dy * dy);
      }
      const float expected = std::sqrt(float(nearest)) - 0.5f;
      EXPECT_EQ(distance.data[size_t(p)], mask.data[size_t(p)] == 200 ? -expected : expected) << p;
    }
  }
}

TEST(SignedDistance, IsInfiniteWithoutAnOtherSide) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  for (const float d : SignedDistance(Image8(4, 3, 1, 127), 128).data) EXPECT_EQ(d, kFar);
  for (const float d : SignedDistance(Image8(4, 3, 1, 128), 128).data) EXPECT_EQ(d, -kFar);
}

}  // namespace
}  // namespace cosplat

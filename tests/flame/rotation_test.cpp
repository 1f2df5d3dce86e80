// flame/math/rotation.h: from what trackers store to axis-angle and back.
#include "flame/math/rotation.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "flame/math/rodrigues.h"

namespace cosplat::flame_math {
namespace {

constexpr double kPi = 3.14159265358979323846;

Vec3<double> RandomAxis(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  return math::Normalize(Vec3<double>{normal(rng), normal(rng), normal(rng)});
}

TEST(Rotation, AxisAngleInvertsRodriguesAtEveryAngle) {
  std::mt19937 rng(1);
  for (const double angle :
       {0.0, 1e-14, 1e-9, 1e-5, 1e-2, 0.5, 1.5, 2.5, 3.0, kPi - 1e-3, kPi - 1e-9})
    for (int i = 0; i < 50; ++i) {
      const Vec3<double> w = RandomAxis(rng) * angle;
      const Vec3<double> back = AxisAngleOf(Rodrigues(w));
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(back[k], w[k], 1e-9) << "angle " << angle;
    }
  // At pi either axis is right.
  for (int axis = 0; axis < 3; ++axis) {
    Vec3<double> w{};
    w[axis] = kPi;
    EXPECT_NEAR(std::abs(AxisAngleOf(Rodrigues(w))[axis]), kPi, 1e-9);
  }
}

TEST(Rotation, SixNumbersAreTheFirstTwoRows) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> uniform(0.1, 3);
  for (int i = 0; i < 50; ++i) {
    const Mat3<double> r = Rodrigues(RandomAxis(rng) * uniform(rng));
    // Rows of any length, the second with a part along the first.
    const double a = uniform(rng), b = uniform(rng), c = uniform(rng);
    std::array<double, 6> six;
    for (int k = 0; k < 3; ++k) {
      six[k] = a * r(0, k);
      six[3 + k] = b * r(1, k) + c * r(0, k);
    }
    Mat3<double> out{};
    ASSERT_TRUE(RotationFrom6d(six, out));
    for (int k = 0; k < 9; ++k) EXPECT_NEAR(out.m[k], r.m[k], 1e-12);
  }
}

TEST(Rotation, SixNumbersThatAreNoRotation) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::array<double, 6> cases[] = {{0, 0, 0, 0, 1, 0},
                                         {1, 0, 0, 0, 0, 0},
                                         {1, 2, 3, 2, 4, 6},
                                         {1, 2, 3, -1e-3, -2e-3, -3e-3},
                                         {nan, 0, 0, 0, 1, 0},
                                         {1, 0, 0, 0, nan, 0},
                                         {1, 0, 0, inf, 0, 0},
                                         {inf, 0, 0, 0, 1, 0}};
  for (const auto& six : cases) {
    Mat3<double> out = {{7}};
    EXPECT_FALSE(RotationFrom6d(six, out)) << six[0] << " " << six[3];
    for (int k = 0; k < 9; ++k) EXPECT_EQ(out.m[k], k == 0 ? 7 : 0);
  }
}

}  // namespace
}  // namespace cosplat::flame_math

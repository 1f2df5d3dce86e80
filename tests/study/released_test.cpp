// avatar/math/released.h: the release's formulas are reproduced, faults and all.
#include "avatar/math/released.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cosplat {
namespace {

using math::Quat;
using math::Vec3;

// FLAME's template enlarged four times: 16 * 0.181554 m^2 over 9,976 faces.
constexpr double kMeanArea = 2.91e-4;

TEST(Released, HalvingATriangleEnlargesItsGaussians) {
  const auto scale = [](double area) {
    return std::exp(math::ReleasedScale<double>(
                        {std::log(.01), std::log(.01), std::log(.01)}, area, kMeanArea, 1.)
                        .y);
  };
  EXPECT_NEAR(scale(kMeanArea), .01, 1e-15);
  EXPECT_NEAR(scale(kMeanArea / 2), .0554, 5e-4);
  EXPECT_LT(scale(kMeanArea * 2), .001);
}

TEST(Released, ScaleIsTheSameInAnyUnit) {
  const double unit = .25;  // FLAME in metres
  const Vec3<double> s4{std::log(.01), std::log(.02), std::log(.03)};
  const double shift = std::log(unit);
  const auto in_units = math::ReleasedScale<double>(s4, 2e-4, kMeanArea, 1.);
  const auto in_metres = math::ReleasedScale<double>({s4.x + shift, s4.y + shift, s4.z + shift},
                                                     2e-4 * unit * unit,
                                                     kMeanArea * unit * unit,
                                                     unit);
  EXPECT_NEAR(in_metres.x, in_units.x + shift, 1e-12);
  EXPECT_NEAR(in_metres.z, in_units.z + shift, 1e-12);
}

TEST(Released, ScaleOfACollapsedTriangleIsFinite) {
  const Vec3<double> s{-5, -5, -5};
  EXPECT_TRUE(std::isfinite(math::ReleasedScale<double>(s, 0, kMeanArea, 1).x));
  EXPECT_TRUE(std::isfinite(math::ReleasedScale<double>(s, kMeanArea, 0, 1).x));
}

TEST(Released, OppositeQuaternionsOfOneRotationCancel) {
  const Quat<double> q = math::Normalize(Quat<double>{.3, -.5, .2, .7});
  const Quat<double> pair[2] = {q, q * -1.0};
  const double half[2] = {.5, .5};
  const auto sum = math::UnalignedSum(pair, half, 2);
  EXPECT_EQ(math::Dot(sum, sum), 0);
  EXPECT_EQ(math::UnalignedBlend(pair, half, 2).w, 1);  // the identity: another rotation
}

TEST(Released, CrossingIsRightForParallelogramsOnly) {
  const Vec3<double> a{0, 0, 0}, b{1, 0, 0}, here{.2, -1, 0};
  const auto crossed = [&](const Vec3<double>& there) {
    double wa = .7, wb = .6, opposite = -.3;  // sums to 1
    math::ParallelogramCrossing(wa, wb, opposite);
    EXPECT_NEAR(wa + wb + opposite, 1, 1e-15);
    EXPECT_GE(opposite, 0);
    return a * wa + b * wb + there * opposite;
  };
  const Vec3<double> point = a * .7 + b * .6 + here * -.3;
  const auto distance = [&](const Vec3<double>& p) {
    return std::sqrt(math::Dot(p - point, p - point));
  };
  EXPECT_NEAR(distance(crossed(a + b - here)), 0, 1e-15);
  EXPECT_GT(distance(crossed({.5, .5, 0})), .1);
}

}  // namespace
}  // namespace cosplat

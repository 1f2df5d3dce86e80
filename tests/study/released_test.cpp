// avatar/math/released.h: the release's formulas are reproduced, faults and all.
#include "avatar/math/released.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/gradient_check.h"

namespace cosplat {
namespace {

using math::Quat;
using math::Vec3;
using test::ExpectVjpMatchesDual;
using test::RandomVector;

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

TEST(Released, ScaleVjp) {
  for (const double area : {0., 1e-4, 5e-4})
    ExpectVjpMatchesDual(
        [](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          const auto s = math::ReleasedScale(Vec3<T>{x[0], x[1], x[2]}, x[3], T(kMeanArea), T(.25));
          return std::vector<T>{s.x, s.y, s.z};
        },
        [](const auto& x, const auto& d) {
          Vec3<double> d_s{0, 0, 0};
          double d_area = 0;
          math::ReleasedScaleVjp<double>(
              {x[0], x[1], x[2]}, x[3], kMeanArea, .25, {d[0], d[1], d[2]}, d_s, d_area);
          return std::vector<double>{d_s.x, d_s.y, d_s.z, d_area};
        },
        {-5, -4, -6, area});
}

TEST(Released, OppositeQuaternionsOfOneRotationCancel) {
  const Quat<double> q = math::Normalize(Quat<double>{.3, -.5, .2, .7});
  const Quat<double> pair[2] = {q, q * -1.0};
  const double half[2] = {.5, .5};
  const auto sum = math::UnalignedSum(pair, half, 2);
  EXPECT_EQ(math::Dot(sum, sum), 0);
  EXPECT_EQ(math::UnalignedBlend(pair, half, 2).w, 1);  // the identity: another rotation
}

TEST(Released, BlendVjp) {
  for (const int count : {1, 3, 6}) {
    auto x = RandomVector(5 * count, 7 + count);
    for (int i = 0; i < count; ++i) x[4 * count + i] = std::abs(x[4 * count + i]);
    ExpectVjpMatchesDual(
        [&](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          std::vector<Quat<T>> q;
          for (int i = 0; i < count; ++i)
            q.push_back({x[4 * i], x[4 * i + 1], x[4 * i + 2], x[4 * i + 3]});
          const auto r = math::UnalignedBlend(q.data(), &x[4 * count], count);
          return std::vector<T>{r.w, r.x, r.y, r.z};
        },
        [&](const auto& x, const auto& d) {
          std::vector<Quat<double>> q, d_q(count);
          for (int i = 0; i < count; ++i)
            q.push_back({x[4 * i], x[4 * i + 1], x[4 * i + 2], x[4 * i + 3]});
          std::vector<double> d_w(count), d_x;
          math::UnalignedBlendVjp(
              q.data(), &x[4 * count], count, {d[0], d[1], d[2], d[3]}, d_q.data(), d_w.data());
          for (const auto& r : d_q) d_x.insert(d_x.end(), {r.w, r.x, r.y, r.z});
          d_x.insert(d_x.end(), d_w.begin(), d_w.end());
          return d_x;
        },
        x);
  }
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

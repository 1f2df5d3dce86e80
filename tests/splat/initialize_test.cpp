// First Gaussians: sizes from neighbours, colours, random points, and points that are not numbers.
#include "splat/train/start/initialize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splat/basis_constants.h"
#include "tests/support/expect_error.h"
#include "tests/support/looking_at.h"

namespace cosplat {
namespace {

using test::LookingAt;

TEST(InitializeFromPoints, TheScaleIsThatOfTheNeighbours) {
  std::vector<float> points;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 3; ++z)
        for (const int v : {x, y, z}) points.push_back(0.25f * float(v));
  const std::vector<uint8_t> colors(points.size(), 128);
  const Gaussians g = InitializeFromPoints(points, colors, 2, Basis::kDcsh);
  ASSERT_EQ(g.size(), 60u);
  EXPECT_EQ(g.degree, 2);
  for (size_t i = 0; i < g.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(g.at(kScaleLog, i)[k], std::log(0.25f), 1e-5);  // every point has three so near
      EXPECT_EQ(g.at(kPosition, i)[k], points[3 * i + k]);
    }
    EXPECT_EQ(g.at(kRotation, i)[0], 1);
    EXPECT_EQ(g.at(kRotation, i)[1], 0);
    EXPECT_NEAR(1 / (1 + std::exp(-g.at(kOpacityLogit, i)[0])), 0.1f, 1e-6);
    for (int k = 0; k < g.width(kColorRest); ++k) EXPECT_EQ(g.at(kColorRest, i)[k], 0);
  }
}

TEST(InitializeFromPoints, TheScaleIsTheRootMeanSquareOfThree) {
  // Neighbours of the first point at 1, 2 and 3; a fourth far away does not count.
  const std::vector<float> points{0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 50, 0, 0};
  const Gaussians g = InitializeFromPoints(points, std::vector<uint8_t>(15, 0), 0, Basis::kSh);
  EXPECT_NEAR(std::exp(g.at(kScaleLog, 0)[1]), std::sqrt(14.0f / 3), 1e-4);
}

TEST(InitializeFromPoints, TheColourIsThePoints) {
  for (const Basis basis : {Basis::kDcsh, Basis::kSh}) {
    const Gaussians g = InitializeFromPoints({0, 0, 0}, {0, 128, 255}, 1, basis);
    const float expected[3] = {0, 128 / 255.0f, 1};
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(0.5f + BasisConstants(basis)[0] * g.at(kColorDc, 0)[k], expected[k], 1e-6);
  }
}

TEST(InitializeFromPoints, OnePointAndCoincidentOnesAreFinite) {
  for (const size_t n : {1, 2, 3, 10}) {
    const Gaussians g = InitializeFromPoints(
        std::vector<float>(3 * n, 0.7f), std::vector<uint8_t>(3 * n, 9), 0, Basis::kDcsh);
    ASSERT_EQ(g.size(), n);
    for (const float s : g.values[kScaleLog]) EXPECT_TRUE(std::isfinite(s));
  }
  const Gaussians one = InitializeFromPoints({1, 2, 3}, {1, 2, 3}, 0, Basis::kDcsh);
  EXPECT_EQ(one.at(kScaleLog, 0)[0], 0);  // no neighbour: one scene unit
}

TEST(InitializeFromPoints, BadPointsAreAnError) {
  test::ExpectError([] { InitializeFromPoints({}, {}, 0, Basis::kDcsh); }, {"points", "no points"});
  for (const float bad : {NAN, INFINITY, -INFINITY})
    test::ExpectError(
        [&] {
          InitializeFromPoints({0, 0, 0, 1, bad, 0}, std::vector<uint8_t>(6, 0), 0, Basis::kDcsh);
        },
        {"points[1]", "finite"});
}

TEST(FocusPoint, IsWhereTheAxesMeet) {
  const std::array<float, 3> target{1, -2, 0.5f};
  std::vector<Camera> cameras;
  for (const std::array<float, 3>& eye :
       {std::array<float, 3>{5, 0, 0}, {0, 6, 1}, {-3, -3, 4}, {2, 2, -7}})
    cameras.push_back(LookingAt(eye, target));
  const auto focus = FocusPoint(cameras);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(focus[k], target[k], 1e-4);
}

TEST(FocusPoint, ParallelAxesAndNoCameraAreFinite) {
  Camera a, b;
  b.translation = {1, 0, 0};
  for (const std::vector<Camera>& cameras :
       {std::vector<Camera>{a, b}, std::vector<Camera>{a}, std::vector<Camera>{}})
    for (const float v : FocusPoint(cameras)) EXPECT_TRUE(std::isfinite(v));
}

TEST(RandomPoints, FillTheSyntheticCube) {
  std::vector<Camera> cameras;
  for (const std::array<float, 3>& eye : {std::array<float, 3>{4, 0, 0}, {0, 4, 1}, {0, 1, 4}})
    cameras.push_back(LookingAt(eye, {0, 0, 0}));
  Rng rng{1};
  std::vector<float> points;
  std::vector<uint8_t> colors;
  RandomPoints(cameras, 2000, rng, points, colors);
  ASSERT_EQ(points.size(), 6000u);
  ASSERT_EQ(colors.size(), 6000u);
  const auto [low, high] = std::minmax_element(points.begin(), points.end());
  EXPECT_GE(*low, -1.3f);
  EXPECT_LE(*high, 1.3f);
  EXPECT_LT(*low, -1.25f);
  EXPECT_GT(*high, 1.25f);
  EXPECT_GT(*std::max_element(colors.begin(), colors.end()), 250);
  Rng again{1}, other{2};
  std::vector<float> same, different;
  RandomPoints(cameras, 2000, again, same, colors);
  RandomPoints(cameras, 2000, other, different, colors);
  EXPECT_EQ(points, same);
  EXPECT_NE(points, different);
}

TEST(RandomPoints, OtherCamerasLookIntoTheCube) {
  const std::array<float, 3> target{10, 20, -5};
  std::vector<Camera> cameras;
  for (const std::array<float, 3>& eye : {std::array<float, 3>{14, 20, -5}, {10, 26, -5}})
    cameras.push_back(LookingAt(eye, target));
  Rng rng{3};
  std::vector<float> points;
  std::vector<uint8_t> colors;
  RandomPoints(cameras, 500, rng, points, colors);
  for (size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(std::abs(points[i] - target[i % 3]), 2.01f);  // half the nearest camera's distance
}

}  // namespace
}  // namespace cosplat

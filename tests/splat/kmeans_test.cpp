// What codebooks are made with.
#include "splat/io/kmeans.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/io/color_weights.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

std::vector<float> RandomRows(size_t count, size_t width, uint64_t seed) {
  Rng rng{seed};
  std::vector<float> rows(count * width);
  for (float& x : rows) x = rng.Normal();
  return rows;
}

// Result of `action` with one thread, and with several.
template <class Action>
auto OnThreads(int threads, const Action& action) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  return action();
}

TEST(NearestRow, IsTheNearest) {
  for (const size_t width : {1, 3, 12, 27, 48, 75})
    for (const size_t candidates : {1, 15, 16, 33, 100})
      for (const size_t count : {1, 6, 95, 97, 200}) {
        const std::vector<float> rows = RandomRows(count, width, 1);
        const std::vector<float> of = RandomRows(candidates, width, 2);
        std::vector<NearestRow> nearest(count);
        FindNearestRows(rows, of, width, nearest);
        for (size_t i = 0; i < count; ++i) {
          std::vector<double> distance2(candidates, 0);
          for (size_t c = 0; c < candidates; ++c)
            for (size_t k = 0; k < width; ++k)
              distance2[c] += std::pow(double(rows[i * width + k]) - of[c * width + k], 2);
          const double min = *std::min_element(distance2.begin(), distance2.end());
          ASSERT_LT(nearest[i].index, candidates);
          // Rounding of a few hundred, the sum of squares, in 24 bits.
          EXPECT_NEAR(distance2[nearest[i].index], min, 1e-4);
          EXPECT_NEAR(nearest[i].distance2, min, 1e-4);
        }
      }
}

TEST(NearestRow, OfEquallyNearOnesTheFirst) {
  const std::vector<float> rows{1, 1, 5, 5};
  std::vector<float> of(2 * 70, 9.0f);
  for (const size_t same : {11, 27, 40, 64}) of[2 * same] = of[2 * same + 1] = 1;
  std::vector<NearestRow> nearest(2);
  FindNearestRows(rows, of, 2, nearest);
  EXPECT_EQ(nearest[0].index, 11u);
  EXPECT_EQ(nearest[0].distance2, 0);
  EXPECT_EQ(nearest[1].index, 0u);
}

TEST(KMeans, FindsSeparateGroups) {
  constexpr size_t kGroups = 5, kRows = 2000;
  Rng rng{3};
  std::vector<float> rows;
  for (size_t i = 0; i < kRows; ++i) {
    rows.push_back(10 * float(i % kGroups) + 0.1f * rng.Normal());
    rows.push_back(0.1f * rng.Normal());
  }
  const Clusters clusters = KMeans(rows, 2, std::vector<float>(kRows, 1.0f), {40, 10, 500, 0});
  EXPECT_EQ(clusters.centers.size(), 80u);
  for (size_t i = 0; i < kRows; ++i)
    EXPECT_NEAR(clusters.centers[2 * clusters.nearest[i]], 10.0 * double(i % kGroups), 1);
}

TEST(KMeans, HeavyRowsPullMore) {
  const std::vector<float> rows{0, 1}, weight{3, 1};
  const Clusters clusters = KMeans(rows, 1, weight, {1, 3, 100, 0});
  EXPECT_EQ(clusters.centers, Buffer<float>{0.25f});
}

TEST(KMeans, RowsThatAreFewOrAlike) {
  const std::vector<float> two{1, 2, 3, 4};
  const Clusters exact = KMeans(two, 2, std::vector<float>{1, 1}, {8192, 10, 100, 0});
  ASSERT_EQ(exact.centers.size(), 4u);
  for (size_t i = 0; i < 2; ++i)
    for (size_t k = 0; k < 2; ++k)
      EXPECT_EQ(exact.centers[2 * exact.nearest[i] + k], two[2 * i + k]);
  const Clusters alike =
      KMeans(std::vector<float>(300, 7.0f), 3, std::vector<float>(100, 1.0f), {10, 10, 50, 0});
  for (const float x : alike.centers) EXPECT_EQ(x, 7);
  EXPECT_TRUE(KMeans(std::vector<float>{}, 3, std::vector<float>{}, {}).nearest.empty());
}

TEST(KMeans, SameBitsForAnyNumberOfThreads) {
  const std::vector<float> rows = RandomRows(3000, 12, 4), weight(3000, 1.0f);
  const auto run = [&] { return KMeans(rows, 12, weight, {200, 4, 1500, 7}); };
  const Clusters one = OnThreads(1, run), many = OnThreads(4, run);
  EXPECT_EQ(one.centers, many.centers);
  EXPECT_EQ(one.nearest, many.nearest);
  EXPECT_NE(KMeans(rows, 12, weight, {200, 4, 1500, 8}).centers, one.centers);
}

TEST(Significance, SizeIsOpacityTimesMeanStandardDeviation) {
  Gaussians g = test::RandomGaussians(1, 0, Basis::kSh, 5);
  *g.at(kOpacityLogit, 0) = 0;
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 0)[k] = std::log(k == 2 ? 4.0f : 1.0f);
  EXPECT_NEAR(SizeSignificance(g)[0], 0.5 * std::cbrt(4.0), 1e-6);
}

TEST(Significance, WhatIsTooLargeToBeDrawnWeighsLeast) {
  const std::vector<float> weights = WeightsOf(std::vector<float>{2, INFINITY, 4, 0});
  EXPECT_EQ(weights, (std::vector<float>{2, 1.5e-4f, 4, 1.5e-4f}));
}

}  // namespace
}  // namespace cosplat

#include "splat/io/vq.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numeric>

#include "splat/io/kmeans.h"
#include "splat/io/nearest_row.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

using test::ExpectError;

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
          const double least = *std::min_element(distance2.begin(), distance2.end());
          ASSERT_LT(nearest[i].index, candidates);
          // Rounding of a few hundred, the sum of squares, in 24 bits.
          EXPECT_NEAR(distance2[nearest[i].index], least, 1e-4);
          EXPECT_NEAR(nearest[i].distance2, least, 1e-4);
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

Gaussians InSh(size_t count, int degree) {
  return test::RandomGaussians(count, degree, Basis::kSh, 5);
}

std::vector<float> Ascending(size_t count) {
  std::vector<float> significance(count);
  std::iota(significance.begin(), significance.end(), 0.0f);
  return significance;
}

TEST(Quantise, KeepsTheMostSignificantAsTheyAre) {
  const Gaussians g = InSh(1000, 2);
  const QuantisedSplats splats = Quantise(g, Ascending(1000), {64, 0.4, 0});
  EXPECT_EQ(splats.bands[2].codebook.size(), 64u * 24);
  EXPECT_EQ(splats.bands[2].index.size(), 600u);
  const Gaussians back = Dequantise(splats);
  EXPECT_EQ(back.degree, 2);
  EXPECT_EQ(back.values[kPosition], g.values[kPosition]);
  EXPECT_EQ(back.values[kScaleLog], g.values[kScaleLog]);
  EXPECT_EQ(back.values[kOpacityLogit], g.values[kOpacityLogit]);
  EXPECT_EQ(back.values[kColorDc], g.values[kColorDc]);
  double error = 0, energy = 0;
  for (size_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(splats.quantised[i], i < 600);
    double norm2 = 0;
    for (int k = 0; k < 4; ++k) norm2 += std::pow(back.at(kRotation, i)[k], 2);
    EXPECT_NEAR(norm2, 1, 1e-6);
    for (int k = 0; k < 24; ++k) {
      if (i >= 600) {
        EXPECT_EQ(back.at(kColorRest, i)[k], g.at(kColorRest, i)[k]);
      }
      error += std::pow(back.at(kColorRest, i)[k] - g.at(kColorRest, i)[k], 2);
      energy += std::pow(g.at(kColorRest, i)[k], 2);
    }
  }
  EXPECT_GT(error, 0);
  EXPECT_LT(error, 0.45 * energy);  // measured 0.38; 0.6 are quantised
  EXPECT_EQ(Dequantise(Quantise(g, Ascending(1000), {64, 1, 0})).values[kColorRest],
            g.values[kColorRest]);
}

TEST(Quantise, EachSplatHasItsOwnDegree) {
  Gaussians g = InSh(500, 3);
  const auto degree_of = [](size_t i) { return int(i % 4); };
  for (size_t i = 0; i < g.size(); ++i)
    for (int k = 3 * (CoefficientCount(degree_of(i)) - 1); k < g.width(kColorRest); ++k)
      g.at(kColorRest, i)[k] = 0;
  const QuantisedSplats splats = Quantise(g, Ascending(500), {8192, 0.5, 0});
  for (int degree = 1; degree <= 3; ++degree) {
    const size_t width = 3 * size_t(CoefficientCount(degree) - 1);
    EXPECT_EQ(splats.bands[degree].kept.size(), (degree < 2 ? 62u : 63u) * width);
    EXPECT_EQ(splats.bands[degree].codebook.size(), 15 * width);  // a row for 4 of 62 or 63
  }
  for (const int degree : {0, 4})
    EXPECT_TRUE(splats.bands[degree].kept.empty() && splats.bands[degree].index.empty());
  for (size_t i = 0; i < g.size(); i += 4) EXPECT_EQ(splats.quantised[i], 0);
  const Gaussians back = Dequantise(splats);
  for (size_t i = 0; i < g.size(); ++i) {
    EXPECT_EQ(splats.own_degree[i], degree_of(i));
    for (int k = 0; k < g.width(kColorRest); ++k) {
      const float was = g.at(kColorRest, i)[k], is = back.at(kColorRest, i)[k];
      if (was == 0 || i >= 250) {
        EXPECT_EQ(is, was);
      }
    }
  }
}

TEST(Quantise, SameBitsForAnyNumberOfThreads) {
  const Gaussians g = InSh(2000, 1);
  const auto run = [&] { return Dequantise(Quantise(g, SizeSignificance(g), {100, 0.3, 2})); };
  const Gaussians one = OnThreads(1, run), many = OnThreads(4, run);
  for (int a = 0; a < kAttributeCount; ++a) EXPECT_EQ(one.values[a], many.values[a]);
}

TEST(Quantise, DegenerateInput) {
  EXPECT_EQ(Dequantise(Quantise(InSh(0, 3), {}, {})).size(), 0u);
  Gaussians g = InSh(3, 1);
  for (int k = 0; k < 4; ++k) g.at(kRotation, 1)[k] = 0;
  const QuantisedSplats splats = Quantise(g, std::vector<float>{0, 0, 0}, {8192, 0, 0});
  EXPECT_EQ(splats.bands[1].index, (std::vector<uint16_t>{0, 0, 0}));
  EXPECT_EQ(std::vector<float>(splats.rotation.begin() + 4, splats.rotation.begin() + 8),
            (std::vector<float>{1, 0, 0, 0}));
  g.basis = Basis::kDcsh;
  ExpectError([&] { Quantise(g, std::vector<float>{0, 0, 0}, {}); }, {"basis", "dcsh", "sh"});
}

TEST(Quantise, WhatIsTooLargeToBeDrawnCountsForNothing) {
  Gaussians g = InSh(40, 1);
  g.at(kScaleLog, 7)[0] = 300;  // a finite number, but its volume is none
  const std::vector<float> significance = SizeSignificance(g);
  ASSERT_TRUE(std::isinf(significance[7]));
  const QuantisedSplats some = Quantise(g, significance, {8, 0.5, 0});
  EXPECT_EQ(some.quantised[7], 1);
  const Gaussians back = Dequantise(Quantise(g, significance, {8, 0, 0}));
  for (const float c : back.values[kColorRest]) ASSERT_TRUE(std::isfinite(c));
}

TEST(SizeSignificance, IsOpacityTimesMeanStandardDeviation) {
  Gaussians g = InSh(1, 0);
  *g.at(kOpacityLogit, 0) = 0;
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 0)[k] = std::log(k == 2 ? 4.0f : 1.0f);
  EXPECT_NEAR(SizeSignificance(g)[0], 0.5 * std::cbrt(4.0), 1e-6);
}

}  // namespace
}  // namespace cosplat

#include "splat/train/optimize/schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace cosplat {
namespace {

TEST(Schedule, Is3dgsAtThirtyThousand) {
  const Schedule absolute, fractions = Schedule::Fractions(30000);
  for (const Schedule& s : {absolute, fractions}) {
    EXPECT_EQ(s.densify_from, 500);
    EXPECT_EQ(s.densify_until, 15000);
    EXPECT_EQ(s.densify_every, 100);
    EXPECT_EQ(s.opacity_reset_every, 3000);
    EXPECT_EQ(s.opacity_reset_share, 1);
    EXPECT_EQ(s.RateShare(30000), 1);
    EXPECT_EQ(s.DownscaleAt(1), 1);
    EXPECT_EQ(s.degree_every, 1000);
    EXPECT_EQ(s.size_prune_after, 3000);
    EXPECT_EQ(s.position_rate_steps, 30000);
  }
}

TEST(Schedule, IsATenthOfItAtThreeThousand) {
  const Schedule s = Schedule::Fractions(3000);
  EXPECT_EQ(s.densify_from, 50);
  EXPECT_EQ(s.densify_until, 1500);
  EXPECT_EQ(s.densify_every, Schedule::kMinDensifyEvery);      // a tenth would be 10
  EXPECT_EQ(s.opacity_reset_every, Schedule::kMinResetEvery);  // and 300
  EXPECT_EQ(s.degree_every, 100);
  EXPECT_EQ(s.size_prune_after, 300);
  EXPECT_EQ(s.position_rate_steps, 3000);
}

// Density control looks at a Gaussian after as many views of it, however few show the part.
TEST(Schedule, OfAPartHasAsManyPassesBetweenEvents) {
  const Schedule s = Schedule::Fractions(3000).OfPart(0.25);
  EXPECT_EQ(s.densify_from, 13);  // 12.5
  EXPECT_EQ(s.densify_until, 375);
  EXPECT_EQ(s.densify_every, 50);
  EXPECT_EQ(s.opacity_reset_every, 125);
  EXPECT_EQ(s.position_rate_steps, 750);
  EXPECT_EQ(Schedule::Fractions(3000).OfPart(1e-6).densify_every, 1);
  EXPECT_FALSE(Schedule::Fractions(10).OfPart(0.01).DensifiesAt(1));
}

TEST(Schedule, ImagesDoubleTheirSides) {
  Schedule s = Schedule::Fractions(3000);
  for (const int i : {1, 300, 3000}) EXPECT_EQ(s.DownscaleAt(i), 1);
  s.num_downscales = 2;
  EXPECT_EQ(s.DownscaleAt(1), 4);
  EXPECT_EQ(s.DownscaleAt(300), 4);
  EXPECT_EQ(s.DownscaleAt(301), 2);
  EXPECT_EQ(s.DownscaleAt(600), 2);
  EXPECT_EQ(s.DownscaleAt(601), 1);
  EXPECT_EQ(s.DownscaleAt(3000), 1);
}

TEST(Schedule, ResetsEndWhereTheyAreTold) {
  Schedule s;
  EXPECT_TRUE(s.ResetsOpacityAt(12000));
  EXPECT_FALSE(s.ResetsOpacityAt(15000));
  s.densify_until = 29000;  // as in SplattingAvatar
  EXPECT_TRUE(s.ResetsOpacityAt(27000));
  s.opacity_reset_share = 0.25f;
  EXPECT_TRUE(s.ResetsOpacityAt(6000));
  EXPECT_FALSE(s.ResetsOpacityAt(9000));
}

TEST(Schedule, RatesFallTowardsTheEnd) {
  Schedule s;
  EXPECT_EQ(s.RateShare(30000), 1);  // 3DGS: they stay
  s.last_rate_share = 0.2f;
  EXPECT_EQ(s.RateShare(24000), 1);
  EXPECT_NEAR(s.RateShare(27000), std::sqrt(0.2f), 1e-6);
  EXPECT_NEAR(s.RateShare(30000), 0.2f, 1e-6);
}

TEST(Schedule, RunsOfAnyLengthHaveAPositiveStep) {
  for (const int iterations : {1, 7, 100}) {
    const Schedule s = Schedule::Fractions(iterations);
    for (int i = 1; i <= iterations; ++i) {  // divides by each interval
      s.DensifiesAt(i);
      s.ResetsOpacityAt(i);
      EXPECT_GE(s.DegreeAt(i, 3), 0);
    }
    EXPECT_GE(s.densify_every, 1);
  }
}

TEST(Schedule, WhenThingsHappen) {
  const Schedule s;
  std::set<int> densifies, resets;
  for (int i = 1; i <= 30000; ++i) {
    if (s.DensifiesAt(i)) densifies.insert(i);
    if (s.ResetsOpacityAt(i)) resets.insert(i);
  }
  EXPECT_EQ(*densifies.begin(), 600);  // 3DGS: iteration > 500, a multiple of 100
  EXPECT_EQ(*densifies.rbegin(), 14900);
  EXPECT_EQ(densifies.size(), 144u);
  EXPECT_EQ(resets, std::set<int>({3000, 6000, 9000, 12000}));
}

TEST(Schedule, DensificationsAfterCountsThem) {
  for (const Schedule& s : {Schedule(), Schedule::Fractions(2000), Schedule::Fractions(777)})
    for (int i = s.densify_from + 1; i < s.densify_until + 50; i += 13) {
      int later = 0;
      for (int k = i + 1; k <= s.densify_until; ++k) later += s.DensifiesAt(k);
      EXPECT_EQ(s.DensificationsAfter(i), later) << i;
    }
}

TEST(Schedule, TheDegreeRisesToTheHighest) {
  const Schedule s;
  EXPECT_EQ(s.DegreeAt(0, 3), 0);
  EXPECT_EQ(s.DegreeAt(999, 3), 0);
  EXPECT_EQ(s.DegreeAt(1000, 3), 1);
  EXPECT_EQ(s.DegreeAt(3000, 3), 3);
  EXPECT_EQ(s.DegreeAt(29000, 3), 3);
  EXPECT_EQ(s.DegreeAt(29000, 4), 4);
}

TEST(Schedule, ThePositionsRateFallsLogLinearly) {
  const Schedule s;
  EXPECT_NEAR(s.PositionRate(0, 1.6e-4f, 1.6e-6f), 1.6e-4, 1e-9);
  EXPECT_NEAR(s.PositionRate(15000, 1.6e-4f, 1.6e-6f), 1.6e-5, 1e-10);
  EXPECT_NEAR(s.PositionRate(30000, 1.6e-4f, 1.6e-6f), 1.6e-6, 1e-11);
  EXPECT_NEAR(s.PositionRate(90000, 1.6e-4f, 1.6e-6f), 1.6e-6, 1e-11);
}

TEST(Schedule, SquaredErrorsCountLessInLongRuns) {
  EXPECT_EQ(Schedule::LateMse(30, 300), 30);
  EXPECT_EQ(Schedule::LateMse(30, 15000), 30);
  EXPECT_EQ(Schedule::LateMse(30, 60000), 7.5f);
}

TEST(Schedule, ColoursLearnFasterInShorterRuns) {
  EXPECT_FLOAT_EQ(Schedule::ColorRate(2.5e-3f, 30000), 2.5e-3f);
  EXPECT_FLOAT_EQ(Schedule::ColorRate(2.5e-3f, 90000), 2.5e-3f);
  EXPECT_FLOAT_EQ(Schedule::ColorRate(2.5e-3f, 15000), 5e-3f);
  EXPECT_FLOAT_EQ(Schedule::ColorRate(2.5e-3f, 7500), 1e-2f);
  EXPECT_FLOAT_EQ(Schedule::ColorRate(2.5e-3f, 100), 1e-2f);
}

TEST(Schedule, LastPositionRateGrowsAsARunGetsShorter) {
  EXPECT_FLOAT_EQ(Schedule::LastPositionRate(1.6e-4f, 30000), 1.6e-6f);
  EXPECT_FLOAT_EQ(Schedule::LastPositionRate(1.6e-4f, 90000), 1.6e-6f);
  EXPECT_FLOAT_EQ(Schedule::LastPositionRate(1.6e-4f, 3000), 1.6e-5f);
  EXPECT_FLOAT_EQ(Schedule::LastPositionRate(1.6e-4f, 10), 1.6e-4f);
}

}  // namespace
}  // namespace cosplat

// Density control: who is cloned, split and removed, and that everything which is per Gaussian
// stays with its Gaussian.
#include "splat/train/density/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/render/rasterizer.h"
#include "splat/train/prune/pruner.h"
#include "tests/splat/tagged_gaussians.h"
#include "tests/support/expect_error.h"
#include "tests/support/morton_order.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: tagged Gaussians

// A step in which Gaussians with these radii were drawn.
void Accumulate(DensityStatistics& s,
                const std::vector<float>& radii,
                const Buffer<float>& screen,
                const Buffer<float>& d_scale_log,
                const Buffer<float>& scale_log,
                int width,
                int height) {
  const uint32_t overflowed = 0;
  s.Accumulate(radii, screen, d_scale_log, scale_log, width, height, &overflowed, HostStream());
}

TEST(DensityStatistics, MeansAreOverTheStepsInWhichItWasSeen) {
  DensityStatistics s;
  s.Reset(2);
  const Buffer<float> scale_log(6, std::log(0.5f));
  const Buffer<float> screen{3, 4, 100, 100}, d_scale_log{1, 2, 2, 100, 100, 100};
  // Gaussian 1 is not drawn in the first step; its gradients there must not count.
  Accumulate(s, {2, 0}, screen, d_scale_log, scale_log, 200, 100);
  Accumulate(s, {7, 5}, screen, d_scale_log, scale_log, 200, 100);
  Accumulate(s, {4, 0}, screen, d_scale_log, scale_log, 200, 100);
  EXPECT_EQ(s.visible, Buffer<float>({3, 1}));
  // Per px -> per half image: |(3 * 100, 4 * 50)|.
  EXPECT_NEAR(s.screen_gradient[0], 3 * std::hypot(300.0f, 200.0f), 1e-3);
  EXPECT_NEAR(s.screen_gradient[1], std::hypot(1e4f, 5e3f), 1e-2);
  // d log s -> d s: 1/0.5.
  EXPECT_NEAR(s.plasticity[0], 3 * 2 * 3, 1e-4);
  EXPECT_NEAR(s.plasticity[1], 2 * std::sqrt(3e4f), 1e-3);
  s.Reset(5);
  EXPECT_EQ(s.visible, Buffer<float>(5, 0.0f));
}

TEST(DensityStatistics, StayFinite) {
  DensityStatistics s;
  s.Reset(3);
  // A deviation that is no float any more (dL/d(log s) is zero with it), a gradient that overflowed
  // and one that is not a number.
  const Buffer<float> scale_log{-200, -1, -1, -1, -1, -1, -1, -1, -1};
  const Buffer<float> d_scale_log{0, 1, 1, INFINITY, 0, 0, 0, 0, 0};
  const Buffer<float> screen{1, 1, 1, 1, NAN, 0};
  Accumulate(s, {1, 1, 1}, screen, d_scale_log, scale_log, 10, 10);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(std::isfinite(s.plasticity[i])) << i;
    EXPECT_TRUE(std::isfinite(s.screen_gradient[i])) << i;
  }
  EXPECT_NEAR(s.plasticity[0], std::sqrt(2.0f) * std::exp(1.0f), 1e-4);
  EXPECT_EQ(s.visible, Buffer<float>({1, 0, 0}));  // nothing was learned of the broken ones
}

TEST(Density, SmallOnesAreClonedLargeOnesSplit) {
  TaggedGaussians p(5);
  p.See(1, 1e-3f, 1);  // small: cloned
  p.See(3, 1e-3f, 1);
  p.SetScale(3, kLarge);  // split
  p.SetScale(4, kLarge);  // no gradient: stays
  const Gaussians before = p.g;
  Recorder recorder(p);
  const DensityReport report = p.Control(recorder);
  EXPECT_EQ(report.cloned, 1u);
  EXPECT_EQ(report.split, 1u);
  EXPECT_EQ(p.Tags(), Tags({1, 2, 3, 5, 2, 4, 4}));
  EXPECT_EQ(recorder.tags, p.Tags());
  EXPECT_EQ(recorder.moved, Tags({4, 4}));
  ExpectAligned(p);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(p.g.at(kPosition, 4)[k], before.at(kPosition, 1)[k]);  // a clone: the same place
    EXPECT_EQ(p.g.at(kScaleLog, 4)[k], before.at(kScaleLog, 1)[k]);
    for (const size_t child : {5, 6}) {
      EXPECT_NEAR(p.g.at(kScaleLog, child)[k], before.at(kScaleLog, 3)[k] - std::log(1.6f), 1e-6);
      EXPECT_NE(p.g.at(kPosition, child)[k], before.at(kPosition, 3)[k]);
    }
    EXPECT_NE(p.g.at(kPosition, 5)[k], p.g.at(kPosition, 6)[k]);
  }
  for (const size_t fresh : {4, 5, 6}) EXPECT_EQ(p.adam.m.at(kScaleLog, fresh)[0], 0);
  for (const size_t old : {0, 1, 2, 3}) EXPECT_NE(p.adam.m.at(kScaleLog, old)[0], 0);
  EXPECT_EQ(p.adam.step, 5);
}

TEST(Density, WhatAdamHasPutOffMustHaveBeenMadeUpFor) {
  TaggedGaussians p(4);
  --p.adam.updated[0];
  test::ExpectError([&] { p.Control(); }, {"density control", "Adam"});
  Placement placement;
  test::ExpectError([&] { p.control.SortInSpace(p.With(placement)); }, {"density control", "Adam"});
}

TEST(Density, SortingInSpaceMovesAllThatIsPerGaussian) {
  TaggedGaussians p(40);
  Rng rng{6};
  for (float& x : p.g.values[kPosition]) x = rng.Normal();
  const Gaussians before = p.g;
  std::vector<std::array<float, 3>> centers;
  for (size_t i = 0; i < 40; ++i) {
    const float* c = before.at(kPosition, i);
    centers.push_back({c[0], c[1], c[2]});
  }
  const std::vector<uint32_t> order = MortonOrder(centers);
  const AdamState adam = p.adam;
  Placement placement;
  p.control.SortInSpace(p.With(placement));
  for (size_t i = 0; i < 40; ++i)
    for (int a = 0; a < kAttributeCount; ++a)
      for (int k = 0; k < before.width(a); ++k) {
        const Attribute attribute = Attribute(a);
        EXPECT_EQ(p.g.at(attribute, i)[k], before.at(attribute, order[i])[k]);
        EXPECT_EQ(p.adam.m.at(attribute, i)[k], adam.m.at(attribute, order[i])[k]);
      }
}

TEST(Density, ChildrenAreDrawnFromTheirParent) {
  // A needle along y, turned by 90 degrees about z: along -x in the world.
  TaggedGaussians p(1);
  const float s = std::sqrt(0.5f);
  const float rotation[4] = {s, 0, 0, s}, scale_log[3] = {-9, 0, -9};
  double sum_x = 0, sum_xx = 0, largest_yz = 0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    TaggedGaussians one(1);
    one.rng.state = uint64_t(i);
    one.See(0, 1, 1);
    std::copy_n(rotation, 4, one.g.at(kRotation, 0));
    std::copy_n(scale_log, 3, one.g.at(kScaleLog, 0));
    one.Control();
    ASSERT_EQ(one.g.size(), 2u);
    for (const size_t child : {0, 1}) {
      const float* at = one.g.at(kPosition, child);
      sum_x += (at[0] - 10) / (2 * n);
      sum_xx += (at[0] - 10) * (at[0] - 10) / (2 * n);
      largest_yz = std::max<double>({largest_yz, std::abs(at[1] - 11), std::abs(at[2] - 12)});
    }
  }
  EXPECT_NEAR(sum_x, 0, 0.05);
  EXPECT_NEAR(sum_xx, 1, 0.07);  // four standard errors
  EXPECT_LT(largest_yz, 6 * std::exp(-9.0));
}

TEST(Density, TheHardCapKeepsTheStrongest) {
  TaggedGaussians p(6);
  for (size_t i = 0; i < 6; ++i) p.See(i, 1e-3f * float(1 + (i * 5) % 6), 1);  // 1 6 5 4 3 2
  p.SetScale(2, kLarge);
  p.settings.max_count = 8;
  const DensityReport report = p.Control();
  EXPECT_EQ(report.cloned, 1u);
  EXPECT_EQ(report.split, 1u);
  EXPECT_EQ(p.Tags(), Tags({1, 2, 4, 5, 6, 2, 3, 3}));
  ExpectAligned(p);
  for (size_t i = 0; i < p.g.size(); ++i) p.See(i, 1, 1);
  p.Control();
  EXPECT_EQ(p.g.size(), 8u);  // full
  p.settings.max_count = 3;   // below what there is
  for (size_t i = 0; i < p.g.size(); ++i) p.See(i, 1, 1);
  p.Control();
  EXPECT_EQ(p.g.size(), 8u);
}

TEST(Density, TwoCopiesAreAsOpaqueAsOneWas) {
  for (const float logit : {-90.0f, -12.0f, -0.1f, 0.0f, 0.1f, 3.0f, 12.0f, 90.0f}) {
    const double shared = math::SharedOpacityLogit(logit);
    ASSERT_TRUE(std::isfinite(shared)) << logit;
    // log(1 - a) = -log(1 + e^l), once and twice.
    const auto log_clear = [](double l) {
      return l > 0 ? -l - std::log1p(std::exp(-l)) : -std::log1p(std::exp(l));
    };
    const double once = log_clear(logit);
    EXPECT_NEAR(2 * log_clear(shared), once, 1e-5 * std::abs(once)) << logit;
  }
}

TEST(Density, ACloneAndItsOriginalShareTheOpacity) {
  for (const bool shares : {false, true}) {
    TaggedGaussians p(3);
    p.settings.shares_opacity = shares;
    for (size_t i = 0; i < 3; ++i) p.g.at(kOpacityLogit, i)[0] = 1;
    p.See(0, 1, 1);         // cloned
    p.SetScale(1, kLarge);  // split: its children are apart
    p.See(1, 1, 1);
    p.Control();
    ASSERT_EQ(p.Tags(), Tags({1, 3, 1, 2, 2}));
    const float shared = shares ? math::SharedOpacityLogit(1) : 1;
    const float expected[5] = {shared, 1, shared, 1, 1};
    for (size_t i = 0; i < 5; ++i) EXPECT_EQ(p.g.at(kOpacityLogit, i)[0], expected[i]) << i;
  }
}

// The longest axis of a Gaussian turned by 90 degrees about z: y of the world.
TEST(Density, CutsInTwoAcrossTheLongestAxis) {
  TaggedGaussians p(3);
  p.settings.cuts_long_axis = true;
  for (const size_t i : {0u, 2u}) {  // one that 3DGS would clone, one that it would split
    p.SetScale(i, i == 0 ? kSmall : kLarge);
    p.g.at(kScaleLog, i)[0] += std::log(2.0f);
    const float turned[4] = {std::sqrt(0.5f), 0, 0, std::sqrt(0.5f)};
    std::copy_n(turned, 4, p.g.at(kRotation, i));
    p.g.at(kOpacityLogit, i)[0] = math::Logit(0.5f);
    p.See(i, 1, 1);
  }
  const Gaussians before = p.g;
  p.Control();
  ASSERT_EQ(p.Tags(), Tags({2, 1, 1, 3, 3}));
  for (size_t child = 1; child < 5; ++child) {
    const size_t whole = child < 3 ? 0 : 2;
    const float scale = whole == 0 ? kSmall : kLarge;
    const float offset = (child % 2 == 1 ? 1.5f : -1.5f) * 2 * scale;
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(p.g.at(kPosition, child)[k],
                  before.at(kPosition, whole)[k] + (k == 1 ? offset : 0),
                  1e-5f);
    EXPECT_NEAR(std::exp(p.g.at(kScaleLog, child)[0]), scale, 1e-5f * scale);
    for (int k = 1; k < 3; ++k)
      EXPECT_NEAR(
          p.g.at(kScaleLog, child)[k], before.at(kScaleLog, whole)[k] + std::log(0.85f), 1e-5f);
    EXPECT_NEAR(p.g.at(kOpacityLogit, child)[0], math::Logit(0.3f), 1e-5f);
  }
}

TEST(Density, HalvesHaveAShareOfTheOpacity) {
  for (const float logit : {-90.0f, -12.0f, -0.1f, 0.0f, 0.1f, 3.0f, 12.0f, 90.0f}) {
    float scales[3] = {0, 1, 0}, half = logit;
    math::CutInHalf(scales, half);
    ASSERT_TRUE(std::isfinite(half)) << logit;
    const auto opacity = [](double l) { return 1 / (1 + std::exp(-l)); };
    EXPECT_NEAR(opacity(half) / opacity(logit), 0.6, 1e-5) << logit;
  }
}

TEST(Density, UnseenOnesAreNotDensified) {
  TaggedGaussians p(2);
  p.statistics.Reset(2);
  p.statistics.screen_gradient[0] = 100;  // of no step
  p.Control();
  EXPECT_EQ(p.Tags(), Tags({1, 2}));
}

TEST(Density, TransparentOversizedAndBrokenOnesGo) {
  TaggedGaussians p(6);
  p.settings.max_scale = 0.5f;
  p.g.at(kOpacityLogit, 0)[0] = -6;  // 0.0025
  p.SetScale(1, 0.6f);               // oversized in the scene
  p.g.at(kColorRest, 3)[4] = NAN;
  p.g.at(kScaleLog, 4)[2] = -INFINITY;
  TaggedGaussians later = p;
  p.Control();  // not yet the oversized one
  EXPECT_EQ(p.Tags(), Tags({2, 3, 6}));
  Placement placement;
  later.Control(placement, true);
  EXPECT_EQ(later.Tags(), Tags({3, 6}));
}

TEST(Density, APlacementMayKeepWhatWouldGo) {
  class Keeper : public Placement {
   public:
    void Veto(const Gaussians& g, const Canvas*, View<uint8_t> unwanted, Stream&) override {
      for (size_t i = 0; i < unwanted.count; ++i)
        if (TagOf(g, i) == 2) unwanted[i] = 0;
    }
  } keeper;
  TaggedGaussians p(3);
  p.g.at(kOpacityLogit, 0)[0] = p.g.at(kOpacityLogit, 1)[0] = -9;
  p.Control(keeper);
  EXPECT_EQ(p.Tags(), Tags({2, 3}));
}

TEST(Density, InThePlaceOfWhatMustStayTheNextOfTheRankingGo) {
  class Keeper : public Placement {
   public:
    void Veto(const Gaussians& g, const Canvas*, View<uint8_t> unwanted, Stream&) override {
      for (size_t i = 0; i < unwanted.count; ++i)
        if (TagOf(g, i) == 1 || TagOf(g, i) == 3) unwanted[i] = 0;
    }
  } keeper;
  TaggedGaussians p(6);
  PruneRound round;
  round.score = {1, 2, 3, 4, 5, 6};
  round.exempt = {0, 0, 0, 1, 0, 0};
  round.remove = 2;
  EXPECT_EQ(p.control.Prune(round, 0, 0, p.With(keeper)), 2u);
  EXPECT_EQ(p.Tags(), Tags({1, 3, 4, 6}));
  // No more than may go.
  round.score = {1, 2, 3, 4};
  round.exempt.clear();
  round.remove = 4;
  EXPECT_EQ(p.control.Prune(round, 0, 0, p.With(keeper)), 2u);
  EXPECT_EQ(p.Tags(), Tags({1, 3}));
}

TEST(Density, EverythingStaysAlignedOverManyRandomRounds) {
  TaggedGaussians p(300);
  Recorder recorder(p);
  Rng rng{5};
  for (int tag = 0; tag <= 300; ++tag) recorder.groups_of_tag.push_back(int(rng.Below(40)));
  p.settings.max_count = 400;
  p.settings.max_scale = 1e9f;
  for (int round = 0; round < 60; ++round) {
    for (size_t i = 0; i < p.g.size(); ++i) {
      p.See(i, rng.Uniform() < 0.3f ? 1.0f : 0.0f, rng.Uniform());
      if (rng.Uniform() < 0.2f) p.statistics.visible[i] = 0;
      p.SetScale(i, rng.Uniform() < 0.5f ? kSmall : 0.02f);
      if (p.adam.m.at(kPosition, i)[0] != 0) continue;
      // As after steps of Adam: those that were new have moments now.
      const float tag = TagOf(p.g, i);
      for (int a = 0; a < kAttributeCount; ++a) {
        std::fill_n(p.adam.m.at(Attribute(a), i), p.g.width(a), tag);
        std::fill_n(p.adam.v.at(Attribute(a), i), p.g.width(a), 2 * tag);
      }
    }
    p.Control(recorder, round % 2);
    ExpectAligned(p);
    ASSERT_EQ(recorder.tags, p.Tags());
    ASSERT_LE(p.g.size(), 400u);
    ASSERT_GT(p.g.size(), 0u);
  }
}

TEST(Density, NothingThere) {
  TaggedGaussians p(0);
  p.Control();
  EXPECT_EQ(p.g.size(), 0u);
}

TEST(ResetOpacity, LowersToOnePercentAndForgetsItsMoments) {
  TaggedGaussians p(3);
  p.g.at(kOpacityLogit, 0)[0] = 3;
  p.g.at(kOpacityLogit, 1)[0] = -7;  // already lower
  ResetOpacity(p.g, p.adam);
  EXPECT_NEAR(1 / (1 + std::exp(-p.g.at(kOpacityLogit, 0)[0])), 0.01, 1e-6);
  EXPECT_EQ(p.g.at(kOpacityLogit, 1)[0], -7);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(p.adam.m.at(kOpacityLogit, i)[0], 0);
    EXPECT_EQ(p.adam.v.at(kOpacityLogit, i)[0], 0);
    EXPECT_EQ(p.adam.m.at(kPosition, i)[0], float(i + 1));
    EXPECT_EQ(p.adam.v.at(kColorDc, i)[2], 2 * float(i + 1));
  }
}

}  // namespace
}  // namespace cosplat

// Density control: who is cloned, split and removed, and that everything which is per Gaussian
// stays with its Gaussian.
#include "splat/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/morton.h"
#include "splat/rasterizer.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

constexpr float kSmall = 0.005f, kLarge = 0.05f;  // below and above DensitySettings::split_scale

// Gaussian i carries its tag, i + 1, in every attribute and moment.
float TagOf(const Gaussians& g, size_t i) { return g.at(kColorDc, i)[0]; }

struct Population {
  Gaussians g;
  AdamState adam;
  DensityStatistics statistics;
  DensitySettings settings;
  Rng rng{1};

  explicit Population(size_t n) {
    g.degree = 1;
    g.Resize(n);
    adam = AdamState(g);
    adam.step = 5;
    adam.updated.assign(adam.updated.size(), 5);
    for (size_t i = 0; i < n; ++i) {
      const float tag = float(i + 1);
      for (int k = 0; k < 3; ++k) {
        g.at(kPosition, i)[k] = 10 * tag + float(k);
        g.at(kColorDc, i)[k] = tag;
      }
      for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = tag + 0.1f * float(k);
      g.at(kRotation, i)[0] = tag;
      g.at(kRotation, i)[1] = 1;
      g.at(kOpacityLogit, i)[0] = 0.001f * tag;
      SetScale(i, kSmall);
      for (int a = 0; a < kAttributeCount; ++a)
        for (int k = 0; k < g.width(a); ++k) {
          adam.m.at(Attribute(a), i)[k] = tag;
          adam.v.at(Attribute(a), i)[k] = 2 * tag;
        }
    }
    statistics.Reset(n);
    for (size_t i = 0; i < n; ++i) See(i, 0, 1);
  }
  void SetScale(size_t i, float scale) {
    for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = std::log(scale) - 0.1f * float(k);
  }
  // Seen in four steps with these means.
  void See(size_t i, float gradient, float plasticity) {
    statistics.visible[i] = 4;
    statistics.screen_gradient[i] = 4 * gradient;
    statistics.plasticity[i] = 4 * plasticity;
  }
  DensityReport Control(Placement& placement, int rounds_left = 0, bool oversized = false) {
    return ControlDensity(settings, oversized, rounds_left, placement, g, adam, statistics, rng);
  }
  DensityReport Control() {
    Placement placement;
    return Control(placement);
  }
  std::vector<int> Tags() const {
    std::vector<int> tags;
    for (size_t i = 0; i < g.size(); ++i) tags.push_back(int(TagOf(g, i)));
    return tags;
  }
};
using Tags = std::vector<int>;

// Follows the tags by itself, as an avatar's binding follows its triangles.
class Recorder : public Placement {
 public:
  explicit Recorder(const Population& p) {
    for (const int tag : p.Tags()) tags.push_back(tag);
  }
  void Gather(const std::vector<uint32_t>& source) override {
    std::vector<int> gathered;
    for (const uint32_t i : source) {
      ASSERT_LT(i, tags.size());
      gathered.push_back(tags[i]);
    }
    tags = gathered;
  }
  void Move(Gaussians& g, uint32_t i, const std::array<float, 3>& offset) override {
    ASSERT_LT(i, tags.size());
    EXPECT_EQ(int(TagOf(g, i)), tags[i]);  // gathered before it is moved
    moved.push_back(tags[i]);
    Placement::Move(g, i, offset);
  }
  std::vector<int32_t> Groups() const override {
    std::vector<int32_t> groups;
    for (const int tag : tags) groups.push_back(groups_of_tag.empty() ? 0 : groups_of_tag[tag]);
    return groups;
  }
  std::vector<int> tags, moved, groups_of_tag;
};

// All that belongs to one Gaussian has its tag; new ones have no moments.
void ExpectAligned(const Population& p) {
  for (size_t i = 0; i < p.g.size(); ++i) {
    const float tag = TagOf(p.g, i);
    EXPECT_EQ(p.g.at(kRotation, i)[0], tag);
    EXPECT_EQ(p.g.at(kOpacityLogit, i)[0], 0.001f * tag);
    for (int k = 0; k < p.g.width(kColorRest); ++k)
      EXPECT_EQ(p.g.at(kColorRest, i)[k], tag + 0.1f * float(k));
    EXPECT_NEAR(p.g.at(kPosition, i)[1], 10 * tag + 1, 1);  // children: 5 deviations away at most
    const bool is_new = p.adam.m.at(kPosition, i)[0] == 0;
    for (int a = 0; a < kAttributeCount; ++a)
      for (int k = 0; k < p.g.width(a); ++k) {
        EXPECT_EQ(p.adam.m.at(Attribute(a), i)[k], is_new ? 0 : tag);
        EXPECT_EQ(p.adam.v.at(Attribute(a), i)[k], is_new ? 0 : 2 * tag);
      }
  }
  for (const Buffer<float>* b : {&p.statistics.screen_gradient,
                                 &p.statistics.plasticity,
                                 &p.statistics.visible,
                                 &p.statistics.max_radius})
    EXPECT_EQ(*b, Buffer<float>(p.g.size(), 0.0f));
}

class FixedTape : public RenderTape {
 public:
  explicit FixedTape(std::vector<float> radii) : radii_(std::move(radii)) {}
  View<const float> radii() const override { return radii_; }
  size_t visible_count() const override { return 0; }
  size_t instance_count() const override { return 0; }
  std::vector<MemoryPart> Memory() const override { return {}; }

 private:
  std::vector<float> radii_;
};

TEST(DensityStatistics, MeansAreOverTheStepsInWhichItWasSeen) {
  DensityStatistics s;
  s.Reset(2);
  const Buffer<float> scale_log(6, std::log(0.5f));
  const Buffer<float> screen{3, 4, 100, 100}, d_scale_log{1, 2, 2, 100, 100, 100};
  // Gaussian 1 is not drawn in the first step; its gradients there must not count.
  s.Accumulate(FixedTape({2, 0}), screen, d_scale_log, scale_log, 200, 100);
  s.Accumulate(FixedTape({7, 5}), screen, d_scale_log, scale_log, 200, 100);
  s.Accumulate(FixedTape({4, 0}), screen, d_scale_log, scale_log, 200, 100);
  EXPECT_EQ(s.visible, Buffer<float>({3, 1}));
  EXPECT_EQ(s.max_radius, Buffer<float>({7, 5}));
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
  s.Accumulate(FixedTape({1, 1, 1}), screen, d_scale_log, scale_log, 10, 10);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(std::isfinite(s.plasticity[i])) << i;
    EXPECT_TRUE(std::isfinite(s.screen_gradient[i])) << i;
  }
  EXPECT_NEAR(s.plasticity[0], std::sqrt(2.0f) * std::exp(1.0f), 1e-4);
  EXPECT_EQ(s.visible, Buffer<float>({1, 0, 0}));  // nothing was learned of the broken ones
}

TEST(Density, SmallOnesAreClonedLargeOnesSplit) {
  Population p(5);
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
  Population p(4);
  --p.adam.updated[0];
  test::ExpectError([&] { p.Control(); }, {"density control", "Adam"});
  Placement placement;
  test::ExpectError([&] { SortInSpace(placement, p.g, p.adam); }, {"density control", "Adam"});
}

TEST(Density, SortingInSpaceMovesAllThatIsPerGaussian) {
  Population p(40);
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
  SortInSpace(placement, p.g, p.adam);
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
  Population p(1);
  const float s = std::sqrt(0.5f);
  const float rotation[4] = {s, 0, 0, s}, scale_log[3] = {-9, 0, -9};
  double sum_x = 0, sum_xx = 0, largest_yz = 0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    Population one(1);
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
  Population p(6);
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

TEST(Density, UnseenOnesAreNotDensified) {
  Population p(2);
  p.statistics.Reset(2);
  p.statistics.screen_gradient[0] = 100;  // of no step
  p.settings.prune_by_plasticity = true;
  p.settings.prune_fraction = 1;
  p.Control();
  EXPECT_EQ(p.Tags(), Tags({1, 2}));
}

TEST(Density, TransparentOversizedAndBrokenOnesGo) {
  Population p(6);
  p.settings.max_scale = 0.5f;
  p.g.at(kOpacityLogit, 0)[0] = -6;  // 0.0025
  p.SetScale(1, 0.6f);               // oversized in the scene
  p.statistics.max_radius[2] = 21;   // and on the screen
  p.g.at(kColorRest, 3)[4] = NAN;
  p.g.at(kScaleLog, 4)[2] = -INFINITY;
  Population later = p;
  DensityReport report = p.Control();
  EXPECT_EQ(report.transparent, 1u);
  EXPECT_EQ(report.broken, 2u);
  EXPECT_EQ(report.oversized, 0u);  // not yet
  EXPECT_EQ(p.Tags(), Tags({2, 3, 6}));
  Placement placement;
  report = later.Control(placement, 0, true);
  EXPECT_EQ(report.oversized, 2u);
  EXPECT_EQ(later.Tags(), Tags({6}));
}

TEST(Density, PlasticityIsOfTheIndicesAfterSplitting) {
  // Splitting the first moves all the others down by one. Scores by the old indices would remove
  // Gaussian 4 in place of 3.
  Population p(5);
  p.See(0, 1, 9);
  p.SetScale(0, kLarge);
  p.See(2, 0, 0.1f);
  p.settings.prune_by_plasticity = true;
  p.settings.prune_fraction = 0.17f;  // of six: one
  const DensityReport report = p.Control();
  EXPECT_EQ(report.unplastic, 1u);
  EXPECT_EQ(p.Tags(), Tags({2, 4, 5, 1, 1}));
  ExpectAligned(p);
}

TEST(Density, PlasticityIsAMeanAndNewOnesAreExempt) {
  Population p(4);
  p.See(0, 1, 5);  // its clone has no score
  p.statistics.visible[1] = 100;
  p.statistics.plasticity[1] = 200;  // mean 2
  p.statistics.visible[2] = 1;
  p.statistics.plasticity[2] = 3;  // mean 3, though the lowest sum
  p.See(3, 0, 4);
  p.settings.prune_by_plasticity = true;
  p.settings.prune_fraction = 0.2f;
  p.Control();
  EXPECT_EQ(p.Tags(), Tags({1, 3, 4, 1}));
}

TEST(Density, PruningCountsOnlyThoseThatStay) {
  // Five transparent ones have the lowest scores; two more go for theirs.
  Population p(10);
  for (size_t i = 0; i < 10; ++i) p.See(i, 0, float(i));
  for (size_t i = 0; i < 5; ++i) p.g.at(kOpacityLogit, i)[0] = -9;
  p.settings.prune_by_plasticity = true;
  p.settings.prune_to = 3;
  const DensityReport report = p.Control();
  EXPECT_EQ(report.transparent, 5u);
  EXPECT_EQ(report.unplastic, 2u);
  EXPECT_EQ(p.Tags(), Tags({8, 9, 10}));
}

TEST(Density, CapAndFloorCountOnlyThoseThatStay) {
  // Two groups of four, of each two transparent. The cap of two asks for no more; the floor of two
  // forbids more.
  Population p(8);
  for (size_t i = 0; i < 8; ++i) {
    p.See(i, 0, float(8 - i));
    if (i % 4 < 2) p.g.at(kOpacityLogit, i)[0] = -9;
  }
  Recorder recorder(p);
  recorder.groups_of_tag = {0, 0, 0, 0, 0, 1, 1, 1, 1};
  p.settings.prune_by_plasticity = true;
  p.settings.prune_fraction = 1;
  p.settings.group_cap = p.settings.group_floor = 2;
  p.Control(recorder);
  EXPECT_EQ(p.Tags(), Tags({3, 4, 7, 8}));
  EXPECT_EQ(recorder.tags, p.Tags());
}

TEST(Density, TheGroupCapHoldsWithoutPlasticityPruning) {
  Population p(6);
  for (size_t i = 0; i < 6; ++i) p.See(i, 1, float(6 - i));
  Recorder recorder(p);
  recorder.groups_of_tag = {0, 0, 0, 0, 0, 1, 1};
  p.settings.group_cap = 3;
  p.Control(recorder);  // all cloned: eight in group 0, four in group 1
  EXPECT_EQ(p.g.size(), 6u);
  for (const int group : {0, 1})
    EXPECT_EQ(std::count_if(recorder.tags.begin(),
                            recorder.tags.end(),
                            [&](int tag) { return recorder.groups_of_tag[tag] == group; }),
              3);
  ExpectAligned(p);
}

TEST(Density, PruneToIsReachedInTheLastRound) {
  Population p(3000);
  p.settings.prune_by_plasticity = true;
  p.settings.prune_to = 700;
  Rng rng{4};
  const int rounds = 15;
  size_t last = p.g.size();
  for (int round = 0; round < rounds; ++round) {
    for (size_t i = 0; i < p.g.size(); ++i)
      p.See(i, rng.Uniform() < 0.05f ? 1.0f : 0.0f, rng.Uniform());
    Placement placement;
    p.Control(placement, rounds - 1 - round);
    ExpectAligned(p);
    // No cliff: each round takes about its share.
    EXPECT_LT(double(last) - double(p.g.size()), 0.2 * double(last));
    last = p.g.size();
  }
  EXPECT_NEAR(double(p.g.size()), 700, 7);
}

TEST(Density, APlacementMayKeepWhatWouldGo) {
  class Keeper : public Placement {
   public:
    void Veto(const Gaussians& g, std::vector<uint32_t>& removed) override {
      std::erase_if(removed, [&](uint32_t i) { return TagOf(g, i) == 2; });
    }
  } keeper;
  Population p(3);
  p.g.at(kOpacityLogit, 0)[0] = p.g.at(kOpacityLogit, 1)[0] = -9;
  p.Control(keeper);
  EXPECT_EQ(p.Tags(), Tags({2, 3}));
}

TEST(Density, EverythingStaysAlignedOverManyRandomRounds) {
  Population p(300);
  Recorder recorder(p);
  Rng rng{5};
  for (int tag = 0; tag <= 300; ++tag) recorder.groups_of_tag.push_back(int(rng.Below(40)));
  p.settings.max_count = 400;
  p.settings.max_scale = 1e9f;
  p.settings.prune_by_plasticity = true;
  p.settings.group_cap = 12;
  p.settings.group_floor = 1;
  for (int round = 0; round < 60; ++round) {
    for (size_t i = 0; i < p.g.size(); ++i) {
      p.See(i, rng.Uniform() < 0.3f ? 1.0f : 0.0f, rng.Uniform());
      p.statistics.max_radius[i] = rng.Uniform() < 0.02f ? 50.0f : 1.0f;
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
    p.Control(recorder, 3, round % 2);
    ExpectAligned(p);
    ASSERT_EQ(recorder.tags, p.Tags());
    ASSERT_LE(p.g.size(), 400u);
    ASSERT_GT(p.g.size(), 0u);
  }
}

TEST(Density, NothingThere) {
  Population p(0);
  p.settings.prune_by_plasticity = true;
  p.Control();
  EXPECT_EQ(p.g.size(), 0u);
}

TEST(ResetOpacity, LowersToOnePercentAndForgetsItsMoments) {
  Population p(3);
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

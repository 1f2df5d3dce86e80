// The rules of pruning: who goes, when, and that runs reach their count.
#include "splat/train/prune/pruner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "splat/train/loss/loss.h"
#include "splat/train/prune/mask_learner.h"
#include "splat/train/prune/rules.h"
#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"
#include "tests/splat/tagged_gaussians.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: tagged Gaussians and small scenes

PruneSettings Rule(const std::string& rule, size_t target = 0) {
  PruneSettings s;
  s.rule = rule;
  s.target = target;
  return s;
}

Schedule Every20() {
  Schedule s = Schedule::Fractions(300);
  s.densify_from = 0;
  s.densify_until = 301;
  s.densify_every = 20;
  return s;
}

// Rounds of a rule on tagged Gaussians, as the trainer makes them.
struct Rounds {
  TaggedGaussians& p;
  std::unique_ptr<Pruner> pruner;
  SceneSubject subject;

  Rounds(TaggedGaussians& p, const PruneSettings& settings)
      : p(p), pruner(MakePruner(settings, Every20(), 300, p.g.size())), subject({}, 1) {}
  size_t Run(Placement& placement, int iteration = 301, int cap = 0, int floor = 0) {
    pruner->BeforeDensification();
    p.control.Control(p.settings, false, p.With(placement, pruner.get()), p.rng);
    ImagesOf images(subject, p.g);
    const PruneRound round =
        pruner->Rank({iteration, images, {}, p.g, p.statistics, 1, {0, 0, 0}, p.rng});
    const size_t gone = p.control.Prune(round, cap, floor, p.With(placement, pruner.get()));
    p.statistics.Reset(p.g.size());
    return gone;
  }
};

TEST(Pruner, NamesAreKnownBothWays) {
  for (const std::string& name : PruneRuleNames()) EXPECT_EQ(FindPruneRule(name).name, name);
  ExpectError([] { FindPruneRule("best"); }, {"prune", "'best'", "dcsharp", "leave-one-out"});
}

TEST(Pruner, ProgramsAddRules) {
  EXPECT_EQ(PruneRuleNames().size(), 11u);  // with those of the study
  const auto none = FindPruneRule("none").make;
  RegisterPruneRule({.name = "of a program", .make = none, .ranks = true});
  EXPECT_EQ(PruneRuleNames().back(), "of a program");
  EXPECT_TRUE(FindPruneRule("of a program").ranks);
  RegisterPruneRule({.name = "of a program", .make = none});
  EXPECT_EQ(PruneRuleNames().size(), 12u);
  EXPECT_FALSE(FindPruneRule("of a program").ranks);
}

TEST(Pruner, SettingsThatDoNotFitTheRuleAreErrors) {
  const auto make = [](PruneSettings s) { MakePruner(s, Every20(), 300, 10); };
  ExpectError([&] { make(Rule("compact", 50)); }, {"--prune-to 50", "compact"});
  ExpectError([&] { make(Rule("none", 50)); }, {"--prune-to 50", "none"});
  PruneSettings opacity = Rule("opacity");
  opacity.mask_weight = 1;
  ExpectError([&] { make(opacity); }, {"--prune-lambda", "opacity"});
  EXPECT_EQ(MakePruner({}, Every20(), 300, 10), nullptr);
}

TEST(Pruner, TheSameRatioInEveryRoundReachesTheTarget) {
  size_t count = 3000;
  for (int left = 14; left >= 0; --left) {
    const size_t gone = RemovalTowards(700, count, left);
    EXPECT_LT(double(gone), 0.2 * double(count));
    count -= gone;
  }
  EXPECT_EQ(count, 700u);
  EXPECT_EQ(RemovalTowards(700, 650, 3), 0u);
}

TEST(Pruner, RoundsAreInProportionToTheRun) {
  const PruneRounds rounds = PruneRounds::Scaled(3000, 15000, 1500, 21000);
  EXPECT_TRUE(rounds.At(1500) && rounds.At(1650) && rounds.At(2100));
  EXPECT_FALSE(rounds.At(1499) || rounds.At(1575) || rounds.At(2250));
  EXPECT_EQ(rounds.LeftAfter(1500), 4);
  EXPECT_EQ(rounds.LeftAfter(2100), 0);
}

TEST(Dcsharp, PlasticityIsOfTheIndicesAfterSplitting) {
  // Splitting the first moves all the others down by one. Scores by the old indices would remove
  // Gaussian 4 in place of 3.
  TaggedGaussians p(5);
  p.See(0, 1, 9);
  p.SetScale(0, kLarge);
  p.See(2, 0, 0.1f);
  Placement placement;
  EXPECT_EQ(Rounds(p, Rule("dcsharp", 5)).Run(placement), 1u);
  EXPECT_EQ(p.Tags(), Tags({2, 4, 5, 1, 1}));
  ExpectAligned(p);
}

TEST(Dcsharp, PlasticityIsAMeanAndNewOnesAreExempt) {
  TaggedGaussians p(4);
  p.See(0, 1, 5);  // its clone has no score
  p.statistics.visible[1] = 100;
  p.statistics.plasticity[1] = 200;  // mean 2
  p.statistics.visible[2] = 1;
  p.statistics.plasticity[2] = 3;  // mean 3, though the lowest sum
  p.See(3, 0, 4);
  Placement placement;
  Rounds(p, Rule("dcsharp", 4)).Run(placement);
  EXPECT_EQ(p.Tags(), Tags({1, 3, 4, 1}));
}

TEST(Dcsharp, CountsOnlyThoseThatStay) {
  // Five transparent ones have the lowest scores; two more go for theirs.
  TaggedGaussians p(10);
  for (size_t i = 0; i < 10; ++i) p.See(i, 0, float(i));
  for (size_t i = 0; i < 5; ++i) p.g.at(kOpacityLogit, i)[0] = -9;
  Placement placement;
  EXPECT_EQ(Rounds(p, Rule("dcsharp", 3)).Run(placement), 2u);
  EXPECT_EQ(p.Tags(), Tags({8, 9, 10}));
}

TEST(Dcsharp, CapAndFloorCountOnlyThoseThatStay) {
  // Two groups of four, of each two transparent. The cap of two asks for no more; the floor of two
  // forbids more.
  TaggedGaussians p(8);
  for (size_t i = 0; i < 8; ++i) {
    p.See(i, 0, float(8 - i));
    if (i % 4 < 2) p.g.at(kOpacityLogit, i)[0] = -9;
  }
  Recorder recorder(p);
  recorder.groups_of_tag = {0, 0, 0, 0, 0, 1, 1, 1, 1};
  Rounds(p, Rule("dcsharp-triangle", 1)).Run(recorder, 301, 2, 2);
  EXPECT_EQ(p.Tags(), Tags({3, 4, 7, 8}));
  EXPECT_EQ(recorder.tags, p.Tags());
}

TEST(Dcsharp, TheCapTakesTheLowestOfItsGroup) {
  TaggedGaussians p(6);
  for (size_t i = 0; i < 6; ++i) p.See(i, 1, float(6 - i));
  Recorder recorder(p);
  recorder.groups_of_tag = {0, 0, 0, 0, 0, 1, 1};
  // All are cloned: eight in group 0, four in group 1.
  Rounds(p, Rule("dcsharp", 12)).Run(recorder, 301, 3);
  EXPECT_EQ(p.g.size(), 6u);
  for (const int group : {0, 1})
    EXPECT_EQ(std::count_if(recorder.tags.begin(),
                            recorder.tags.end(),
                            [&](int tag) { return recorder.groups_of_tag[tag] == group; }),
              3);
  ExpectAligned(p);
}

TEST(DcsharpReleased, TakesTheHighestByTheirPlaceBeforeSplitting) {
  // 2 % of a hundred: Gaussians 10 and 51 move the most. The first splits, so that all after it
  // stand one place further down when they are taken: 11 and 52 go in their place.
  TaggedGaussians p(100);
  for (size_t i = 0; i < 100; ++i) p.See(i, 0, 1);
  p.See(0, 1, 1);
  p.SetScale(0, kLarge);
  Rounds rounds(p, Rule("dcsharp-released"));
  Gaussians gradients = p.g.ZerosLike();
  for (const size_t i : {9, 50}) gradients.at(kScaleLog, i)[0] = 3;
  gradients.at(kScaleLog, 70)[1] = 100;  // the other axes do not count
  gradients.at(kScaleLog, 80)[0] = 100;  // nor what was not drawn
  std::vector<float> radii(100, 1.0f);
  radii[80] = 0;
  rounds.pruner->AfterBackward(p.g, gradients, radii);
  Placement placement;
  EXPECT_EQ(rounds.Run(placement), 2u);
  std::vector<int> tags = p.Tags();
  for (const int kept : {10, 51, 71, 81}) EXPECT_EQ(std::count(tags.begin(), tags.end(), kept), 1);
  for (const int gone : {11, 52}) EXPECT_EQ(std::count(tags.begin(), tags.end(), gone), 0);
}

// A run of the small scene that densifies freely, under a rule.
struct Outcome {
  size_t count;
  double psnr;
};
TrainSettings RunSettings(const PruneSettings& prune) {
  TrainSettings s = ShortRun(300, 1);
  s.prune = prune;
  return s;
}
Outcome TrainUnder(const PruneSettings& prune, uint64_t seed = 3) {
  const std::vector<TrainFrame> frames = TargetImages(TrueScene(1), Ring(6, 2.2f));
  SceneSubject subject(frames, 1);
  TrainSettings settings = RunSettings(prune);
  settings.seed = seed;
  const TrainingState state = Train(settings, subject, FirstGaussians(300, 1), 300);
  return {state.gaussians.size(), MeanPsnr(state.gaussians, frames)};
}

TEST(Pruner, RulesThatRankReachTheirCount) {
  const Outcome all = TrainUnder({});
  ASSERT_GT(all.count, 250u);
  for (const char* rule :
       {"leave-one-out", "dcsharp", "lightgaussian", "speedy", "opacity", "random"}) {
    const Outcome run = TrainUnder(Rule(rule, 80));
    EXPECT_NEAR(double(run.count), 80, 3) << rule;
    EXPECT_GT(run.psnr, 15) << rule;
  }
}

TEST(Pruner, RulesThatRankHaveSharesOfTheirOwn) {
  const size_t all = TrainUnder({}).count;
  for (const char* rule : {"leave-one-out",
                           "dcsharp",
                           "dcsharp-released",
                           "lightgaussian",
                           "speedy",
                           "opacity",
                           "random"})
    EXPECT_LT(TrainUnder(Rule(rule)).count, all) << rule;
}

TEST(Pruner, LeavingOutByErrorBeatsChance) {
  EXPECT_GT(TrainUnder(Rule("leave-one-out", 60)).psnr, TrainUnder(Rule("random", 60)).psnr + 1);
}

// How many Gaussians are needed is found in the run: by how much the images may lose.
// Means of eight runs: one scatters by 0.7 dB.
TEST(Pruner, LeavingOutWithoutACountLosesWhatItMay) {
  const auto mean = [](const PruneSettings& prune) {
    constexpr int kRuns = 8;
    Outcome sum{0, 0};
    for (int seed = 0; seed < kRuns; ++seed) {
      const Outcome run = TrainUnder(prune, uint64_t(seed));
      sum.count += run.count, sum.psnr += run.psnr / kRuns;
    }
    return sum;
  };
  const Outcome all = mean({});
  size_t last = all.count + 1;
  for (const double tolerance : {0.0, 0.1, 1.0, 3.0}) {
    PruneSettings settings = Rule("leave-one-out");
    settings.tolerance = tolerance;
    const Outcome run = mean(settings);
    EXPECT_LT(run.count, last) << tolerance;
    EXPECT_GT(run.psnr, all.psnr - tolerance - 1) << tolerance;
    last = run.count;
  }
}

// A rule's mask, learned as training does.
struct MaskInStep {
  explicit MaskInStep(Pruner& pruner) { learner.Upload(pruner.Mask(), HostStream()); }
  WorldGaussians BeforeDraw(const Gaussians& g, Rng& rng) {
    WorldGaussians world = ViewOf(g);
    learner.BeforeDraw(g, rng, world, HostStream());
    rng = rng.After(learner.DrawsOf(g.size()));
    return world;
  }
  double AfterBackward(const Gaussians& g, Gaussians& gradients, View<const float> radii) {
    const uint32_t overflowed = 0;
    learner.AfterBackward(g, radii, &overflowed, gradients, HostStream());
    return *learner.value();
  }
  MaskLearner learner;
};

// Gaussians that the images do not need give their masks no gradient: the mask's own loss hides
// them in time. Those whose opacity the images ask for stay.
TEST(Pruner, AMaskHidesWhatTheImagesDoNotAskFor) {
  for (const char* rule : {"compact", "lp"}) {
    const Gaussians g = TrueScene(0);
    SceneSubject subject(TargetImages(g, Ring(2, 2.2f)), 1);
    const auto pruner = MakePruner(Rule(rule), Every20(), 300, g.size());
    Rng rng{1};
    const std::vector<uint32_t> frames{0, 1};
    ImagesOf images(subject, g);
    const PruneContext context{195, images, frames, g, {}, 0, {0, 0, 0}, rng};
    EXPECT_EQ(pruner->Rank(context).remove, 0u) << rule;
    const std::vector<float> radii(g.size(), 1.0f);
    MaskInStep mask(*pruner);
    for (int step = 0; step < 3000; ++step) {
      mask.BeforeDraw(g, rng);
      Gaussians gradients = g.ZerosLike();
      for (size_t i = 0; i < g.size(); i += 2) *gradients.at(kOpacityLogit, i) = -1;
      EXPECT_GE(mask.AfterBackward(g, gradients, radii), 0);
    }
    mask.learner.Download(HostStream());
    const PruneRound round = pruner->Rank(context);
    EXPECT_EQ(round.remove, g.size() / 2) << rule;
    for (size_t i = 0; i < g.size(); i += 2) EXPECT_GT(round.score[i], round.score[i + 1]) << rule;
  }
}

TEST(Compact, WhatIsHiddenIsNotDrawn) {
  const Gaussians g = TrueScene(0);
  const auto pruner = MakePruner(Rule("compact"), Every20(), 300, g.size());
  Rng rng{1};
  const std::vector<float> radii(g.size(), 0.0f);
  Gaussians gradients = g.ZerosLike();
  MaskInStep mask(*pruner);
  EXPECT_EQ(mask.BeforeDraw(g, rng).opacity_logit[0], *g.at(kOpacityLogit, 0));
  for (int step = 0; step < 3000; ++step) mask.AfterBackward(g, gradients, radii);
  EXPECT_LT(mask.BeforeDraw(g, rng).opacity_logit[0], -50);
}

// The soft mask changes the image; the opacities' gradient goes through it.
TEST(Lp, GradientsGoThroughTheMask) {
  const Gaussians truth = TrueScene(0);
  SceneSubject subject(TargetImages(truth, Ring(1, 2.2f)), 1);
  Gaussians g = truth;
  Rng colors{3};
  for (float& c : g.values[kColorDc]) c += 0.3f * colors.Normal();
  for (float& o : g.values[kOpacityLogit]) o = 0.5f;
  PruneSettings settings = Rule("lp");
  const auto pruner = MakePruner(settings, Every20(), 300, g.size());
  Rng unused{1};
  const std::vector<uint32_t> frames{0};
  ImagesOf images(subject, g);
  pruner->Rank({195, images, frames, g, {}, 0, {0, 0, 0}, unused});  // begins to learn
  MaskInStep mask(*pruner);

  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  Buffer<float> d_color, screen;
  const auto loss_of = [&](const Gaussians& at) {
    Rng rng{9};  // the same noise each time
    const WorldGaussians world = mask.BeforeDraw(at, rng);
    rasterizer->Forward(world, at.basis, subject.frame(0).camera, {{0, 0, 0}, 0}, image, *tape);
    return PhotometricLoss().Evaluate(
        {0, 0, 1}, image.color, subject.frame(0).target, {0, 0, 0}, d_color);
  };
  loss_of(g);
  Rng rng{9};
  const WorldGaussians world = mask.BeforeDraw(g, rng);
  Gaussians gradients = g.ZerosLike();
  rasterizer->Backward(world, image, d_color, *tape, GradientViewOf(gradients, screen));
  std::vector<double> numeric;
  for (size_t i = 0; i < 8; ++i) {
    Gaussians up = g, down = g;
    constexpr float kStep = 2e-2f;
    *up.at(kOpacityLogit, i) += kStep;
    *down.at(kOpacityLogit, i) -= kStep;
    numeric.push_back((loss_of(up) - loss_of(down)) / (2 * double(kStep)));
  }
  loss_of(g);
  mask.AfterBackward(g, gradients, tape->radii());
  double largest = 0;
  for (const double d : numeric) largest = std::max(largest, std::abs(d));
  ASSERT_GT(largest, 1e-6);
  for (size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(*gradients.at(kOpacityLogit, i), numeric[i], 0.03 * largest) << i;
}

TEST(Pruner, SameSeedSameBits) {
  for (const char* rule : {"leave-one-out", "lp", "compact"}) {
    SceneSubject subject(TargetImages(TrueScene(1), Ring(6, 2.2f)), 1);
    PruneSettings prune = Rule(rule);
    const TrainingState a = Train(RunSettings(prune), subject, FirstGaussians(300, 1), 220);
    const TrainingState b = Train(RunSettings(prune), subject, FirstGaussians(300, 1), 220);
    EXPECT_TRUE(SameBits(a, b)) << rule;
  }
}

}  // namespace
}  // namespace cosplat

// The training loop on a synthetic scene: it overfits, its bits depend on the seed alone, and every
// setting does what it says.
#include "splat/train/trainer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <map>

#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/morton_order.h"

namespace cosplat {
namespace {

using namespace test;

TEST(Trainer, OverfitsASceneFromRandomPoints) {
  const auto frames = TargetImages(TrueScene(1), Ring(6, 2.2f));
  for (const Basis basis : {Basis::kDcsh, Basis::kSh}) {
    SceneSubject subject(frames, 1);
    const Gaussians first = FirstGaussians(200, 1, basis);
    EXPECT_LT(MeanPsnr(first, frames), 15);
    // Measured 41.8 dB with dcsh, 41.7 with sh.
    const TrainingState state = Train(ShortRun(500, 1), subject, first, 500);
    EXPECT_GT(MeanPsnr(state.gaussians, frames), 37) << ToString(basis);
  }
}

// A rule that counts in pixels can be right at one size only. With removal above 20 px the larger
// images end with 2,480 Gaussians, without it with 5,000; the smaller ones with 5,000 either way.
// The PSNR (46.4, 50.3 and 48.7 dB) says the same, but scatters by 3 dB between compilers' options.
TEST(Trainer, LargerImagesEndWithAsManyGaussians) {
  double count[2];
  const int sides[2] = {48, 384};
  for (int i = 0; i < 2; ++i) {
    SceneSubject subject(TargetImages(TrueScene(1), Ring(6, 2.2f, sides[i])), 1);
    TrainSettings settings = ShortRun(600, 1);
    settings.density.max_count = 5000;
    count[i] = double(Train(settings, subject, FirstGaussians(200, 1), 600).gaussians.size());
  }
  EXPECT_GT(count[1], 0.7 * count[0]);
}

// The same bits as a run on the smaller images, until they grow; and no smaller than a loss with
// windows can judge.
TEST(Trainer, TheFirstImagesAreSmaller) {
  const auto frames = TargetImages(TrueScene(1), Ring(3, 2.2f, 208));
  std::vector<TrainFrame> halves;
  for (const TrainFrame& frame : frames) halves.push_back(Reduced(frame, 2));
  TrainSettings settings = ShortRun(300, 1);
  SceneSubject small(halves, 1), full(frames, 1);
  Trainer on_small(settings, small, FirstGaussians(100, 1));
  settings.schedule.num_downscales = 2;
  settings.schedule.downscale_every = 5;
  Trainer growing(settings, full, FirstGaussians(100, 1));
  for (int i = 0; i < 10; ++i) ASSERT_EQ(growing.Step().loss, on_small.Step().loss) << i;
  EXPECT_TRUE(SameBits(growing.state(), on_small.state()));
  EXPECT_NE(growing.Step().loss, on_small.Step().loss);
}

// An image that must not be reduced keeps the others from it: an engine keeps those of one size.
TEST(Trainer, ImagesOfSeveralSizesAreReducedAlike) {
  auto frames = TargetImages(TrueScene(1), Ring(3, 2.2f, 208));
  frames[1] = TargetImages(TrueScene(1), Ring(3, 2.2f, 150))[1];
  SceneSubject subject(frames, 1);
  TrainSettings settings = ShortRun(300, 1);
  const TrainingState full = Train(settings, subject, FirstGaussians(100, 1), 6);
  settings.schedule.num_downscales = 1;
  EXPECT_TRUE(SameBits(Train(settings, subject, FirstGaussians(100, 1), 6), full));
}

Gaussians Perturbed(Gaussians g) {
  Rng rng{2};
  for (int a = 0; a < kAttributeCount; ++a)
    for (float& v : g.values[a]) v += (a == kPosition ? 0.02f : 0.1f) * rng.Normal();
  return g;
}

TEST(Trainer, RecoversAPerturbedScene) {
  const Gaussians truth = TrueScene(2);
  const auto frames = TargetImages(truth, Ring(6, 2.2f));
  const Gaussians first = Perturbed(truth);
  TrainSettings settings = ShortRun(300, 2);
  settings.first_degree = 2;
  settings.schedule.densify_until = 0;
  SceneSubject subject(frames, 1);
  const double before = MeanPsnr(first, frames);
  const TrainingState state = Train(settings, subject, first, 300);
  EXPECT_EQ(state.gaussians.size(), truth.size());
  EXPECT_GT(MeanPsnr(state.gaussians, frames), before + 10);
  EXPECT_GT(MeanPsnr(state.gaussians, frames), 34);
}

// 150 steps with densification, splits, plasticity pruning and resets of opacity.
TrainSettings BusyRun() {
  TrainSettings settings = ShortRun(300, 2);
  settings.schedule.densify_from = 10;
  settings.schedule.densify_every = 20;
  settings.schedule.opacity_reset_every = 60;
  settings.background = Background::kRandom;
  settings.prune.rule = "dcsharp";
  return settings;
}

TrainingState RunBusily(const TrainSettings& settings) {
  SceneSubject subject(TargetImages(TrueScene(2), Ring(6, 2.2f), true), 1);
  return Train(settings, subject, FirstGaussians(300, 2), 150);
}

TEST(Trainer, BitsDependOnTheSeedAlone) {
  std::vector<TrainingState> states;
  for (const int threads : {1, 4, 2}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    states.push_back(RunBusily(BusyRun()));
  }
  EXPECT_NE(states[0].gaussians.size(), 300u);
  EXPECT_TRUE(SameBits(states[0], states[1]));
  EXPECT_TRUE(SameBits(states[0], states[2]));
  TrainSettings other = BusyRun();
  other.seed = 4;
  EXPECT_FALSE(SameBits(states[0].gaussians, RunBusily(other).gaussians));
}

// Cameras inside, so that each sees a part of it, and neighbours in space beside each other, so
// that whole groups are out of sight. Not densified, which makes small differences large.
struct SceneSeenInParts {
  Gaussians first;
  std::vector<TrainFrame> frames;
  TrainSettings settings = ShortRun(400, 1);

  SceneSeenInParts() {
    Gaussians truth = TrueScene(1, 1000);
    for (float& s : truth.values[kScaleLog]) s -= std::log(4.0f);
    frames = TargetImages(truth, Ring(12, 0.3f));
    first = Perturbed(truth);
    std::vector<std::array<float, 3>> centers;
    for (size_t i = 0; i < first.size(); ++i) {
      const float* p = first.at(kPosition, i);
      centers.push_back({p[0], p[1], p[2]});
    }
    first.Gather(MortonOrder(centers));
    settings.first_degree = 1;
    settings.schedule.densify_until = 0;
  }
};

TEST(Trainer, AdamOnWhatIsDrawnIsAsGoodAsOnAll) {
  SceneSeenInParts scene;
  constexpr int kSeeds = 4;
  double psnr[2] = {};
  for (int seed = 0; seed < kSeeds; ++seed)
    for (const AdamOn on : {AdamOn::kAll, AdamOn::kDrawn}) {
      SceneSubject subject(scene.frames, 1);
      scene.settings.adam_on = on;
      scene.settings.seed = uint64_t(seed);
      const TrainingState state = Train(scene.settings, subject, scene.first, 400);
      psnr[int(on)] += MeanPsnr(state.gaussians, scene.frames) / kSeeds;
      // At the end nothing is put off.
      for (const int64_t step : state.adam.updated) EXPECT_EQ(step, state.adam.step);
    }
  // Measured over eight seeds: 36.3 dB on all, 36.0 on those drawn; single runs scatter by 0.9 dB.
  EXPECT_GT(psnr[1], psnr[0] - 1);
  EXPECT_NE(psnr[1], psnr[0]);
}

TEST(Trainer, WhatIsSavedMidwayIsCaughtUpAndChangesNothing) {
  SceneSeenInParts scene;
  scene.settings.iterations = 60;
  SceneSubject subject(scene.frames, 1);
  Trainer trainer(scene.settings, subject, scene.first);
  for (int i = 0; i < 30; ++i) trainer.Step();
  const TrainingState before = trainer.state();
  const Gaussians caught_up = trainer.CaughtUp();
  EXPECT_TRUE(SameBits(before, trainer.state()));
  EXPECT_FALSE(SameBits(before.gaussians, caught_up));
  for (int i = 30; i < 60; ++i) trainer.Step();
  EXPECT_TRUE(SameBits(trainer.state().gaussians, trainer.CaughtUp()));  // at the end
}

TEST(Trainer, EveryFrameOncePerPass) {
  class Counter : public SceneSubject {
   public:
    using SceneSubject::SceneSubject;
    WorldGaussians ToWorld(const Gaussians& g, size_t i) override {
      order.push_back(i);
      return SceneSubject::ToWorld(g, i);
    }
    std::vector<size_t> order;
  };
  Counter subject(TargetImages(TrueScene(0, 3), Ring(5, 2.2f, 16)), 1);
  Train(ShortRun(100, 0), subject, TrueScene(0, 3), 20);
  std::vector<std::vector<size_t>> passes;
  for (int pass = 0; pass < 4; ++pass) {
    passes.emplace_back(subject.order.begin() + 5 * pass, subject.order.begin() + 5 * pass + 5);
    std::vector<size_t> sorted = passes.back();
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, std::vector<size_t>({0, 1, 2, 3, 4}));
  }
  EXPECT_FALSE(passes[0] == passes[1] && passes[1] == passes[2]);
}

TEST(Trainer, GuessesComeLateAndSayLessAboutShapes) {
  class Guesses : public SceneSubject {
   public:
    Guesses(std::vector<TrainFrame> frames, size_t from)
        : SceneSubject(std::move(frames), 1), from_(from) {}
    bool IsGuess(size_t i) const override { return i >= from_; }
    WorldGaussians ToWorld(const Gaussians& g, size_t i) override {
      order.push_back(i);
      return SceneSubject::ToWorld(g, i);
    }
    std::vector<size_t> order;

   private:
    size_t from_;
  };
  const auto frames = TargetImages(TrueScene(0, 3), Ring(4, 2.2f, 16));
  TrainSettings settings = ShortRun(100, 0);
  settings.schedule.densify_until = 9;
  Guesses mixed(frames, 3);
  Train(settings, mixed, TrueScene(0, 3), 17);
  EXPECT_EQ(std::count(mixed.order.begin(), mixed.order.begin() + 9, 3u), 0);
  EXPECT_EQ(std::count(mixed.order.begin() + 9, mixed.order.end(), 3u), 2);
  // A tenth of a first gradient is in the moments.
  settings.schedule.densify_until = 0;
  Guesses all(frames, 0), none(frames, 4);
  const AdamState of_guess = Train(settings, all, FirstGaussians(20, 0), 1).adam;
  const AdamState of_frame = Train(settings, none, FirstGaussians(20, 0), 1).adam;
  for (int a = 0; a < kAttributeCount; ++a) {
    const float share = a == kScaleLog || a == kOpacityLogit ? 0.3f : 1.0f;
    for (size_t i = 0; i < of_frame.m.values[a].size(); ++i)
      ASSERT_NEAR(of_guess.m.values[a][i], share * of_frame.m.values[a][i], 1e-9) << a;
  }
}

TEST(Trainer, TheDegreeIsRaisedAndHigherBandsWait) {
  SceneSubject subject(TargetImages(TrueScene(2), Ring(3, 2.2f, 24)), 1);
  TrainSettings settings = ShortRun(3000, 2);
  settings.schedule.degree_every = 4;
  Trainer trainer(settings, subject, FirstGaussians(50, 2));
  const auto largest = [&](int from, int to) {  // |coefficients| of these bands
    float max = 0;
    const Gaussians& g = trainer.state().gaussians;
    for (size_t i = 0; i < g.size(); ++i)
      for (int k = 3 * (CoefficientCount(from - 1) - 1); k < 3 * (CoefficientCount(to) - 1); ++k)
        max = std::max(max, std::abs(g.at(kColorRest, i)[k]));
    return max;
  };
  for (int step = 1; step <= 14; ++step) {
    EXPECT_EQ(trainer.active_degree(), std::min(2, (step - 1) / 4));
    trainer.Step();
    EXPECT_EQ(largest(1, 1) > 0, step > 4) << step;
    EXPECT_EQ(largest(2, 2) > 0, step > 8) << step;
  }
  settings.first_degree = 2;
  EXPECT_EQ(Trainer(settings, subject, FirstGaussians(5, 2)).active_degree(), 2);
}

TEST(Trainer, TheHardCapHoldsInEveryStep) {
  SceneSubject subject(TargetImages(TrueScene(1), Ring(6, 2.2f)), 1);
  TrainSettings settings = BusyRun();
  settings.background = Background::kBlack;
  settings.density.gradient_threshold = 0;
  settings.density.max_count = 333;
  Trainer trainer(settings, subject, FirstGaussians(300, 2));
  size_t max = 0;
  for (int i = 0; i < 60; ++i) max = std::max(max, trainer.Step().gaussians);
  EXPECT_LE(max, 333u);
  EXPECT_GT(max, 325u);  // 2 % are pruned in the same round
}

TEST(Trainer, ARandomBackgroundKeepsTheOutsideTransparent) {
  const std::vector<Camera> cameras = Ring(6, 2.2f);
  const auto frames = TargetImages(TrueScene(0), cameras, true);
  const auto alpha_outside = [&](Background background) {
    TrainSettings settings = ShortRun(300, 0);
    settings.background = background;
    settings.schedule.densify_until = 0;
    SceneSubject subject(frames, 1);
    Gaussians first = FirstGaussians(400, 0);
    first.values[kColorDc].assign(first.values[kColorDc].size(), -1.7f);  // black
    const TrainingState state = Train(settings, subject, first, 300);
    double sum = 0, count = 0;
    for (const TrainFrame& frame : frames) {
      const RenderedImage image = Render(state.gaussians, frame.camera);
      for (size_t i = 0; i < image.transmittance.size(); ++i)
        if (frame.target.data[4 * i + 3] == 0) {
          sum += 1 - image.transmittance[i];
          ++count;
        }
    }
    EXPECT_GT(count, 1000);
    return sum / count;
  };
  const double random = alpha_outside(Background::kRandom);
  EXPECT_LT(random, 0.02);
  // On black, black splats cost nothing.
  EXPECT_GT(alpha_outside(Background::kBlack), 5 * random);
}

// The loss of the first step with one opaque black splat over the whole image, or none.
double FirstLoss(const Image8& target, Background background, bool nothing_to_draw) {
  Gaussians g;
  g.Resize(1);
  for (int k = 0; k < 3; ++k) {
    g.at(kScaleLog, 0)[k] = 3;
    g.at(kColorDc, 0)[k] = -10;
  }
  g.at(kRotation, 0)[0] = 1;
  g.at(kOpacityLogit, 0)[0] = nothing_to_draw ? -20.0f : 20.0f;
  TrainSettings settings = ShortRun(100, 0);
  settings.background = background;
  settings.loss = {0, 0, 1};
  SceneSubject subject({{LookingAt({0, 0, 3}, {0, 0, 0}, target.width), target}}, 1);
  return Trainer(settings, subject, g).Step().loss;
}

TEST(Trainer, Backgrounds) {
  const Image8 clear(12, 12, 4, 0), white(12, 12, 3, 255);
  // A transparent target is the background itself, whichever it is.
  for (const Background b : {Background::kBlack, Background::kWhite, Background::kRandom})
    EXPECT_NEAR(FirstLoss(clear, b, true), 0, 1e-12);
  EXPECT_NEAR(FirstLoss(clear, Background::kBlack, false), 0, 1e-12);
  EXPECT_NEAR(FirstLoss(clear, Background::kWhite, false), 0.98, 0.02);
  EXPECT_GT(FirstLoss(clear, Background::kRandom, false), 0.01);
  EXPECT_NEAR(FirstLoss(white, Background::kBlack, true), 1, 1e-6);
  EXPECT_NEAR(FirstLoss(white, Background::kWhite, true), 0, 1e-12);
}

TEST(Trainer, TheRegulariserPullsNeedlesAlone) {
  // The first is a needle, the second large and round, the third a small needle.
  Gaussians g = TrueScene(0, 3);
  const float scale[3][3] = {{0.5f, 0.01f, 0.01f}, {0.4f, 0.4f, 0.4f}, {5e-3f, 1e-4f, 1e-4f}};
  for (size_t i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      g.at(kScaleLog, i)[k] = std::log(scale[i][k]);
      g.at(kPosition, i)[k] = 50;  // out of sight: no gradient from the image
    }
  SceneSubject subject(TargetImages(TrueScene(0, 3), Ring(2, 2.2f, 16)), 1);
  TrainSettings settings = ShortRun(100, 0);
  settings.scale_regularizer.weight = 0.3f;
  Trainer with(settings, subject, g);
  const double loss_with = with.Step().loss;
  settings.scale_regularizer.weight = 0;
  Trainer without(settings, subject, g);
  EXPECT_NEAR(loss_with - without.Step().loss, 0.3 * 0.5, 1e-6);
  const Gaussians& after = with.state().gaussians;
  EXPECT_LT(after.at(kScaleLog, 0)[0], g.at(kScaleLog, 0)[0]);
  EXPECT_EQ(after.at(kScaleLog, 0)[1], g.at(kScaleLog, 0)[1]);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(after.at(kScaleLog, 1)[k], g.at(kScaleLog, 1)[k]);
    EXPECT_EQ(after.at(kScaleLog, 2)[k], g.at(kScaleLog, 2)[k]);
  }
}

TEST(Trainer, BadInputIsAnErrorThatNamesIt) {
  SceneSubject none({}, 1);
  ExpectError([&] { Trainer(ShortRun(10, 0), none, TrueScene(0, 1)); }, {"training frames"});

  auto frames = TargetImages(TrueScene(0, 2), Ring(1, 2.2f, 16));
  TrainSettings settings = ShortRun(10, 0);
  settings.loss.l1 = NAN;
  SceneSubject subject(frames, 1);
  Trainer broken(settings, subject, TrueScene(0, 2));
  ExpectError([&] { broken.Step(); }, {"iteration 1", "not finite"});

  frames[0].target = Image8(16, 15, 3);
  SceneSubject smaller(frames, 1);
  Trainer mismatched(ShortRun(10, 0), smaller, TrueScene(0, 2));
  ExpectError([&] { mismatched.Step(); }, {"training frame 0", "16x15", "16x16"});

  settings = ShortRun(10, 3);  // more bands than the Gaussians store
  settings.first_degree = 3;
  Trainer missing(settings, subject, TrueScene(0, 2));
  ExpectError([&] { missing.Step(); }, {"degree"});
}

TEST(Trainer, PruningEverythingIsAnError) {
  SceneSubject subject(TargetImages(TrueScene(0, 2), Ring(1, 2.2f, 16)), 1);
  Gaussians g = TrueScene(0, 2);
  for (float& logit : g.values[kOpacityLogit]) logit = -9;
  TrainSettings settings = ShortRun(3, 0);
  settings.schedule.densify_from = 0;
  settings.schedule.densify_until = 3;
  settings.schedule.densify_every = 2;
  // Also where a rule would rank those that are left.
  for (const char* rule : {"none", "lp", "random"}) {
    settings.prune.rule = rule;
    Trainer trainer(settings, subject, g);
    trainer.Step();
    ExpectError([&] { trainer.Step(); }, {"iteration 2", "pruned"});
  }
}

TEST(Trainer, ABrokenGaussianIsRemovedAndTheRestTrains) {
  const auto frames = TargetImages(TrueScene(1), Ring(6, 2.2f));
  Gaussians first = FirstGaussians(200, 1);
  first.at(kPosition, 7)[1] = NAN;
  first.at(kColorRest, 9)[3] = INFINITY;
  TrainSettings settings = ShortRun(300, 1);
  SceneSubject subject(frames, 1);
  const TrainingState state = Train(settings, subject, first, 300);
  for (int a = 0; a < kAttributeCount; ++a)
    for (const float v : state.gaussians.values[a]) ASSERT_TRUE(std::isfinite(v));
  EXPECT_GT(MeanPsnr(state.gaussians, frames), 33);
}

TEST(Trainer, StatisticsCountTheRun) {
  SceneSubject subject(TargetImages(TrueScene(0, 4), Ring(2, 2.2f, 16)), 1);
  Trainer trainer(ShortRun(3000, 0), subject, TrueScene(0, 4));
  EXPECT_EQ(trainer.statistics().iterations, 0);
  EXPECT_EQ(trainer.statistics().ms_per_step, 0);
  for (int i = 1; i <= 3; ++i) EXPECT_EQ(trainer.Step().iteration, i);
  const TrainingStatistics s = trainer.statistics();
  EXPECT_EQ(s.iterations, 3);
  EXPECT_EQ(s.gaussians, 4u);
  EXPECT_EQ(s.ignored_gradients, 0u);
  EXPECT_GT(s.seconds, 0);
  double phases = 0;
  for (const double p : s.times.seconds) phases += p;
  EXPECT_GT(phases, 0);
  EXPECT_LE(phases, s.seconds * 1.01);
}

}  // namespace
}  // namespace cosplat

// Bands dropped in training.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "splat/device/for_each.h"
#include "splat/train/density/bands.h"
#include "splat/train/step/kernels/step.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"

namespace cosplat {
namespace {

// Images of a scene whose colours change with the direction by so much; and a run on them.
struct SmallRun {
  SmallRun(float shine, float threshold, int iterations = 240)
      : settings(test::ShortRun(iterations, 3)) {
    std::vector<Camera> cameras;
    for (int k = 0; k < 8; ++k) {
      const float a = 0.785f * float(k);
      cameras.push_back(
          test::LookingAt({2.5f * std::cos(a), 0.6f, 2.5f * std::sin(a)}, {0, 0, 0}, 32));
    }
    Gaussians truth = test::TrueScene(2);
    for (float& c : truth.values[kColorRest]) c *= shine;
    frames = test::TargetImages(truth, cameras);
    settings.drop_bands = threshold;
    settings.schedule.degree_every = 20;
  }
  TrainingState Train(int threads = 2) const {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SceneSubject subject(frames, 1);
    return test::Train(settings, subject, first, settings.iterations);
  }
  TrainSettings settings;
  std::vector<TrainFrame> frames;
  Gaussians first = test::FirstGaussians(150, 3);
};

double MeanDegree(const Gaussians& g) { return FiguresOf(CountDegrees(g), g.degree).mean; }

TEST(BandsInTraining, TrainingIsTheSameForAnyNumberOfThreads) {
  const SmallRun run(1, 10 / 255.0f, 90);
  const TrainingState one = run.Train(1), four = run.Train(4);
  EXPECT_FALSE(one.gaussians.degrees.empty());
  EXPECT_EQ(one.gaussians.degrees, four.gaussians.degrees);
  EXPECT_TRUE(test::SameBits(one, four));
}

double SumOfSquares(const Buffer<float>& values) {
  double sum = 0;
  for (const float x : values) sum += double(x) * x;
  return sum;
}

// A few views say little of how colours depend on direction.
TEST(BandsInTraining, AreSmoothWhereFewViewsAre) {
  SmallRun run(1, 0);
  const double free = SumOfSquares(run.Train().gaussians.values[kColorRest]);
  run.settings.color_curvature = 0.03f;
  const TrainingState smooth = run.Train();
  EXPECT_LT(SumOfSquares(smooth.gaussians.values[kColorRest]), 0.7 * free);
  EXPECT_TRUE(test::SameBits(smooth, run.Train(1)));
  run.settings.batch = 4;
  EXPECT_LT(SumOfSquares(run.Train().gaussians.values[kColorRest]), 0.7 * free);
}

TEST(BandsInTraining, AreFreeWhereManyViewsAre) {
  TrainSettings settings;
  settings.color_curvature = 6;
  EXPECT_EQ(settings.ColorCurvatureOf(3, 12), 0.5f);
  EXPECT_EQ(settings.ColorCurvatureOf(25, 12), 0.5f);
  EXPECT_FLOAT_EQ(settings.ColorCurvatureOf(40, 12), 0.2f);
  EXPECT_EQ(settings.ColorCurvatureOf(50, 12), 0);
  EXPECT_EQ(settings.ColorCurvatureOf(100, 12), 0);
}

TEST(BandsInTraining, TheKernelAddsTheDerivativeOfVisibleOnes) {
  const Buffer<float> visible{1, 0}, rest{0.5f, -1, 2, 3, 4, 5};
  Buffer<float> d_rest{1, 1, 1, 1, 1, 1};
  ColorCurvatureBackward kernel{{2, 2, 2}, visible.view(), rest.view(), d_rest.view(), 3};
  ForEach(2, HostStream(), kernel);
  EXPECT_EQ(std::vector<float>(d_rest.begin(), d_rest.end()),
            (std::vector<float>{2, -1, 5, 1, 1, 1}));
}

TEST(BandsInTraining, WhatWasDroppedStaysSo) {
  const SmallRun run(1, 10 / 255.0f, 90);
  SceneSubject subject(run.frames, 1);
  Trainer trainer(run.settings, subject, run.first);
  Buffer<uint8_t> degrees;
  int rounds = 0;
  for (int i = 1; i <= run.settings.iterations; ++i) {
    trainer.Step();
    const Gaussians& g = trainer.state().gaussians;
    if (BandSchedule::DropsAt(i, run.settings.iterations)) {
      ++rounds;
      if (!degrees.empty()) {
        for (size_t k = 0; k < g.size(); ++k) EXPECT_LE(g.degrees[k], degrees[k]);
      }
      degrees = g.degrees;
    }
    EXPECT_EQ(g.degrees, degrees);
    for (size_t k = 0; k < degrees.size(); ++k) EXPECT_LE(HighestBand(g, k), degrees[k]);
  }
  EXPECT_EQ(rounds, BandSchedule::kRounds);
  const TrainingStatistics statistics = trainer.statistics();
  EXPECT_EQ(statistics.degrees, CountDegrees(trainer.state().gaussians));
  EXPECT_GT(statistics.bands.rest_saved, 0.05);
  EXPECT_NE(statistics.drop_psnr, 0);
}

TEST(BandsInTraining, TheSceneDecides) {
  // Six grey levels: what Gaussians of so small a scene make up beside what is there.
  const double dull = MeanDegree(SmallRun(0, 6 / 255.0f).Train().gaussians),
               shiny = MeanDegree(SmallRun(4, 6 / 255.0f).Train().gaussians);
  EXPECT_LT(dull, 0.5);  // measured: 0.26
  EXPECT_GT(shiny, 1);   // 1.12
}

}  // namespace
}  // namespace cosplat

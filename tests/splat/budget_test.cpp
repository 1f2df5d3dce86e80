// Finding the budget of Gaussians: what is tried, what is chosen, and that the run is then one that
// was told the count.
#include "splat/train/budget.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small scenes

constexpr int kSteps = 300;

TrainSettings Settings() {
  TrainSettings s = ShortRun(kSteps, 1);
  s.prune.rule = "leave-one-out";
  return s;
}

std::vector<TrainFrame> Frames() { return TargetImages(TrueScene(1), Ring(10, 2.2f)); }

BudgetReport FindBudget(const BudgetSettings& settings, Trainer& trainer) {
  BudgetSearch search(settings, trainer);
  while (!search.done()) search.Step();
  return search.report();
}

TEST(Budget, FramesAreHeldOut) {
  EXPECT_EQ(FramesForBudget(21, false), (std::vector<uint32_t>{4, 12, 20}));
  EXPECT_EQ(FramesForBudget(12, true), (std::vector<uint32_t>{10, 11}));
  EXPECT_TRUE(FramesForBudget(4, true).empty());
  EXPECT_TRUE(FramesForBudget(0, false).empty());
}

TEST(Budget, TheFewestThatHoldAreChosen) {
  SceneSubject subject(Frames(), 1);
  Trainer trainer(Settings(), subject, FirstGaussians(300, 1));
  const BudgetSettings settings{1.0, FramesForBudget(subject.frame_count(), true)};
  std::vector<size_t> shown;
  BudgetSearch search(settings, trainer);
  while (!search.done()) {
    shown.push_back(search.trials());
    search.Step();
  }
  const BudgetReport& report = search.report();
  ASSERT_GE(report.trials.size(), 3u);
  const BudgetTrial& all = report.trials.front();
  EXPECT_LT(report.chosen, all.gaussians / 2);
  size_t fewest = all.gaussians;
  for (const BudgetTrial& trial : report.trials)
    if (trial.psnr >= all.psnr - settings.tolerance_db) fewest = std::min(fewest, trial.gaussians);
  EXPECT_NEAR(double(report.chosen), double(fewest), 1);
  EXPECT_TRUE(std::is_sorted(shown.begin(), shown.end()));
  EXPECT_EQ(shown.back() + 1, report.trials.size());
  EXPECT_EQ(trainer.statistics().steps, shown.size());

  // The run has not begun, and has the bits of one that was told the count.
  EXPECT_EQ(trainer.state().iteration, 0);
  while (trainer.state().iteration < kSteps) trainer.Step();
  EXPECT_EQ(trainer.state().gaussians.size(), report.chosen);
  TrainSettings told = Settings();
  told.prune.target = report.chosen;
  Trainer fixed(told, subject, FirstGaussians(300, 1));
  while (fixed.state().iteration < kSteps) fixed.Step();
  EXPECT_TRUE(SameBits(fixed.state(), trainer.state()));
}

TEST(Budget, ATighterToleranceNeedsMore) {
  std::vector<size_t> chosen;
  for (const double tolerance : {0.05, 3.0}) {
    SceneSubject subject(Frames(), 1);
    Trainer trainer(Settings(), subject, FirstGaussians(300, 1));
    chosen.push_back(FindBudget({tolerance, {8, 9}}, trainer).chosen);
  }
  EXPECT_GT(chosen[0], chosen[1]);
}

TEST(Budget, NoLossAllowedKeepsAllWhereAllAreNeeded) {
  SceneSubject subject(Frames(), 1);
  Trainer trainer(Settings(), subject, FirstGaussians(300, 1));
  const BudgetReport report = FindBudget({-100, {8, 9}}, trainer);
  EXPECT_EQ(report.chosen, report.trials.front().gaussians);
  while (trainer.state().iteration < kSteps) trainer.Step();
  EXPECT_EQ(trainer.state().gaussians.size(), report.chosen);
}

TEST(Budget, WhatCannotBeJudgedIsAnError) {
  SceneSubject subject(Frames(), 1);
  Trainer trainer(Settings(), subject, FirstGaussians(300, 1));
  ExpectError([&] { FindBudget({0.2, {}}, trainer); }, {"--budget auto", "frames"});
  TrainSettings none = Settings();
  none.prune.rule = "none";
  Trainer unpruned(none, subject, FirstGaussians(300, 1));
  ExpectError([&] { FindBudget({0.2, {1}}, unpruned); }, {"--budget auto", "no round"});
}

TEST(Trainer, GoingBackRepeatsTheRunBitForBit) {
  SceneSubject subject(Frames(), 1);
  Trainer trainer(Settings(), subject, FirstGaussians(300, 1));
  for (int i = 0; i < 120; ++i) trainer.Step();
  const Trainer::Checkpoint checkpoint = trainer.Save();
  for (int i = 120; i < 220; ++i) trainer.Step();
  const TrainingState first = trainer.state();
  trainer.Restore(checkpoint, trainer.settings().prune);
  for (int i = 120; i < 220; ++i) trainer.Step();
  EXPECT_TRUE(SameBits(first, trainer.state()));
}

TEST(Trainer, GoingBackForgetsWhatTrialsDropped) {
  SceneSubject subject(Frames(), 1);
  TrainSettings settings = Settings();
  settings.drop_bands = 0.02f;
  Trainer trainer(settings, subject, FirstGaussians(300, 1));
  for (int i = 0; i < 120; ++i) trainer.Step();
  const Trainer::Checkpoint checkpoint = trainer.Save();
  std::vector<double> dropped;
  for (int trial = 0; trial < 2; ++trial) {
    trainer.Restore(checkpoint, trainer.settings().prune);
    while (trainer.state().iteration < kSteps) trainer.Step();
    dropped.push_back(trainer.statistics().drop_psnr);
  }
  EXPECT_NE(dropped[0], 0);
  EXPECT_EQ(dropped[0], dropped[1]);
}

TEST(Trainer, FramesHeldOutAreNotTrainedOn) {
  SceneSubject subject(Frames(), 1);
  Trainer trainer(ShortRun(kSteps, 1), subject, FirstGaussians(300, 1));
  const auto is_ahead = [&](uint32_t frame) {
    const std::vector<uint32_t>& left = trainer.state().frames_left;
    return std::count(left.begin(), left.end(), frame) > 0;
  };
  trainer.HoldOut({3, 7});
  for (int i = 0; i < 16; ++i) {
    trainer.Step();
    EXPECT_FALSE(is_ahead(3) || is_ahead(7));
    EXPECT_EQ(trainer.state().frames_left.size(), size_t(7 - i % 8));  // passes of eight
  }
  trainer.HoldOut({});
  trainer.Step();
  EXPECT_EQ(trainer.state().frames_left.size(), 9u);
  ExpectError([&] { trainer.HoldOut({0, 1, 2, 3, 4, 5, 6, 7, 8, 9}); }, {"training frames"});
}

TEST(Trainer, PsnrIsThatOfImages) {
  const Gaussians truth = TrueScene(0);
  const std::vector<TrainFrame> frames = TargetImages(truth, Ring(3, 2.2f));
  SceneSubject subject(frames, 1);
  Trainer trainer(ShortRun(kSteps, 0), subject, truth);
  // Bytes round: a quantisation noise of 1/sqrt(12) of a grey level is 58.9 dB.
  EXPECT_NEAR(trainer.PsnrOf(std::vector<uint32_t>{0, 1, 2}), 59, 2);
}

}  // namespace
}  // namespace cosplat

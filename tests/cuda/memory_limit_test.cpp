// Training on a device whose memory is nearly full: it goes on with as many Gaussians as fit.
#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include "tests/parity/training_run.h"

namespace cosplat {
namespace {

struct MemoryLimit : testing::Test {
  void SetUp() override { cuda_on_host::SetSchedule(1); }
  void TearDown() override { cuda_on_host::SetFreeMemory(before); }
  size_t before = cuda_on_host::FreeMemory();
};

constexpr size_t kScarce = 150000;  // bytes

// The largest number of Gaussians, and what was said.
struct Outcome {
  size_t largest = 0;
  std::vector<std::string> notices;
};

Outcome TrainWhereMemoryRunsOut(int batch, size_t free) {
  test::TrainingRun run;
  run.settings.batch = batch;
  run.settings.density.gradient_threshold = 0;  // all want to be two
  run.settings.density.max_count = 100000;
  run.settings.schedule.densify_every = 5;
  SceneSubject subject(run.frames, 1);
  Trainer trainer(run.settings, subject, run.first, test::OnDevice(cuda::SumOrder::kFixed));
  Outcome outcome;
  for (int i = 0; i < 40; i += batch) {
    if (i == 12) cuda_on_host::SetFreeMemory(free);
    const StepReport step = trainer.Step();
    outcome.largest = std::max(outcome.largest, step.gaussians);
    if (!step.notice.empty()) outcome.notices.push_back(step.notice);
  }
  return outcome;
}

TEST_F(MemoryLimit, TrainingGoesOnWithWhatFits) {
  const Outcome outcome = TrainWhereMemoryRunsOut(1, 400000);
  ASSERT_EQ(outcome.notices.size(), 1u) << "once";
  const std::string& notice = outcome.notices[0];
  EXPECT_NE(notice.find("memory is nearly full"), std::string::npos) << notice;
  EXPECT_EQ(notice.find('\n'), std::string::npos);
  EXPECT_GT(outcome.largest, test::TrainingRun().first.size());
  EXPECT_LT(outcome.largest, 1000u);
}

// Several views need room for their sums.
TEST_F(MemoryLimit, StepsOfSeveralViewsGoOnWithWhatFits) {
  const Outcome outcome = TrainWhereMemoryRunsOut(4, 400000);
  EXPECT_EQ(outcome.notices.size(), 1u);
  EXPECT_GT(outcome.largest, test::TrainingRun().first.size());
  EXPECT_LT(outcome.largest, 1000u);
}

// Eight times the instances of a frame do not fit, those that there are do: their number is waited
// for, and the run has the bits of one with all the memory that it wants.
TEST_F(MemoryLimit, ThePredictedCapacityMayBeMoreThanFits) {
  test::TrainingRun run;
  run.settings.schedule.densify_until = 0;
  const StepEngineMaker foresees_much = test::OnDevice(cuda::SumOrder::kFixed, InstanceForecast(8));
  const test::Training roomy = RunOn(run, foresees_much, 12);
  SceneSubject subject(run.frames, 1);
  Trainer trainer(run.settings, subject, run.first, foresees_much);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(trainer.Step().loss, roomy.losses[size_t(i)]) << i;
    if (i == 0) cuda_on_host::SetFreeMemory(kScarce);
  }
  EXPECT_TRUE(test::SameBits(trainer.state(), roomy.state));
}

}  // namespace
}  // namespace cosplat

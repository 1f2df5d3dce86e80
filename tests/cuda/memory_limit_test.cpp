// Training on a device whose memory is nearly full: it goes on with as many Gaussians as fit.
#include <gtest/gtest.h>

#include "splat/cuda/device_memory.h"
#include "tests/parity/training_run.h"

namespace cosplat {
namespace {

struct MemoryLimit : testing::Test {
  void SetUp() override { cuda_on_host::SetSchedule(1); }
  void TearDown() override { cuda_on_host::SetFreeMemory(before); }
  size_t before = cuda_on_host::FreeMemory();
};

// The largest number of Gaussians, and what was said.
struct Outcome {
  size_t largest = 0;
  std::vector<std::string> notices;
};

Outcome TrainWhereMemoryRunsOut() {
  test::TrainingRun run;
  run.settings.density.gradient_threshold = 0;  // all want to be two
  run.settings.density.max_count = 100000;
  run.settings.schedule.densify_every = 5;
  SceneSubject subject(run.frames, 1);
  Trainer trainer(
      run.settings, subject, run.first, cuda::MakeDeviceStepEngine(cuda::SumOrder::kFixed));
  Outcome outcome;
  for (int i = 0; i < 40; ++i) {
    if (i == 12) cuda_on_host::SetFreeMemory(400000);
    const StepReport step = trainer.Step();
    outcome.largest = std::max(outcome.largest, step.gaussians);
    if (!step.notice.empty()) outcome.notices.push_back(step.notice);
  }
  return outcome;
}

TEST_F(MemoryLimit, TrainingGoesOnWithWhatFits) {
  const Outcome outcome = TrainWhereMemoryRunsOut();
  ASSERT_EQ(outcome.notices.size(), 1u) << "once";
  const std::string& notice = outcome.notices[0];
  EXPECT_NE(notice.find("memory is nearly full"), std::string::npos) << notice;
  EXPECT_EQ(notice.find('\n'), std::string::npos);
  EXPECT_GT(outcome.largest, test::TrainingRun().first.size());
  EXPECT_LT(outcome.largest, 1000u);
}

}  // namespace
}  // namespace cosplat

// Training on a device whose memory is nearly full: it goes on with as many Gaussians as fit.
#include <gtest/gtest.h>

#include "splat/cuda/device_memory.h"
#include "tests/parity/training_run.h"

namespace cosplat {
namespace {

using test::OnDevice;

struct MemoryLimit : testing::Test {
  void SetUp() override { cuda_on_host::SetSchedule(1); }
  void TearDown() override { cuda_on_host::SetFreeMemory(before); }
  size_t before = cuda_on_host::FreeMemory();
};

TEST_F(MemoryLimit, TrainingGoesOnWithWhatFits) {
  test::TrainingRun run;
  run.settings.density.gradient_threshold = 0;  // all want to be two
  run.settings.density.max_count = 100000;
  run.settings.schedule.densify_every = 5;
  SceneSubject subject(run.frames, 1);
  Trainer trainer(run.settings, subject, run.first, OnDevice(cuda::SumOrder::kFixed));
  std::vector<std::string> notices;
  size_t largest = 0;
  for (int i = 0; i < 40; ++i) {
    if (i == 12) cuda_on_host::SetFreeMemory(400000);
    const StepReport step = trainer.Step();
    largest = std::max(largest, step.gaussians);
    if (!step.notice.empty()) notices.push_back(step.notice);
  }
  ASSERT_EQ(notices.size(), 1u) << "once";
  EXPECT_NE(notices[0].find("memory is nearly full"), std::string::npos) << notices[0];
  EXPECT_EQ(notices[0].find('\n'), std::string::npos);
  EXPECT_GT(largest, run.first.size());
  EXPECT_LT(largest, 1000u);
  EXPECT_GT(cuda_on_host::FreeMemory(), 0u);
}

}  // namespace
}  // namespace cosplat

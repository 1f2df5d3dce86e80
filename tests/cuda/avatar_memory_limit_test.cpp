// An avatar's training on a device whose memory is nearly full: what is per Gaussian beside its
// parameters counts, too.
#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include "avatar/train/avatar_subject.h"
#include "tests/avatar/training_fixture.h"

namespace cosplat {
namespace {

struct AvatarMemoryLimit : testing::Test {
  void SetUp() override { cuda_on_host::SetSchedule(1); }
  void TearDown() override { cuda_on_host::SetFreeMemory(before); }
  size_t before = cuda_on_host::FreeMemory();
};

// An allocation that does not fit would end it.
TEST_F(AvatarMemoryLimit, TrainingGoesOnWithWhatFits) {
  AvatarSettings avatar = test::SmallAvatar(100);
  avatar.walk_every = 7;
  AvatarSubject subject(test::SmallVideo::Get().flame, test::LoadSmallVideo(3, 4), avatar);
  TrainSettings settings = test::ShortRun(100, 100000);
  settings.degree = 1;
  ScaleToUnit(subject.extent(), settings);
  settings.density.gradient_threshold = 0;  // all want to be two
  settings.schedule.densify_every = 5;
  Trainer trainer(settings,
                  subject,
                  subject.InitialGaussians(1, Basis::kDcsh, 3),
                  AvatarEngineOn(Device::kCuda, true));
  size_t largest = 0;
  std::vector<std::string> notices;
  for (int i = 0; i < 26; ++i) {
    if (i == 7) cuda_on_host::SetFreeMemory(500000);
    const StepReport step = trainer.Step();
    largest = std::max(largest, step.gaussians);
    if (!step.notice.empty()) notices.push_back(step.notice);
  }
  ASSERT_EQ(notices.size(), 1u) << "once";
  EXPECT_NE(notices[0].find("memory is nearly full"), std::string::npos) << notices[0];
  EXPECT_GT(largest, 200u);
  EXPECT_LT(largest, 1000u);
}

// A refined avatar's bytes after each kind of work; what it foresees for a Gaussian of it.
struct Held {
  size_t bytes = 0, per_gaussian = 0;
};
Held HeldWith(size_t gaussians) {
  AvatarSettings avatar = test::SmallAvatar(gaussians);
  avatar.refine_track = true;
  AvatarSubject subject(test::SmallVideo::Get().flame, test::LoadSmallVideo(3, 4), avatar);
  TrainingState state;
  state.gaussians = subject.InitialGaussians(0, Basis::kDcsh, 3);
  state.adam = AdamState(state.gaussians);
  state.statistics.Reset(gaussians);
  const TrainSettings settings;
  const auto engine = AvatarEngineOn(Device::kCuda, true)(settings, subject, state);
  StepPlan plan{1, 0, {}, {}, true};
  engine->Step({&plan, 1});
  engine->AfterStep(avatar.walk_every);
  engine->CatchUp({});
  PruneRound nothing;
  nothing.score.assign(gaussians, 1);
  engine->Prune(nothing, 0, 0);
  engine->SortInSpace();
  return {SumOf(subject.Memory(), MemoryOf::kGaussians), subject.BytesPerGaussian()};
}

TEST_F(AvatarMemoryLimit, BytesPerGaussianAreThoseThatAreHeld) {
  const Held few = HeldWith(1000), many = HeldWith(3000);
  // Buffers have room for a little more than was asked for.
  const double grown = double(many.bytes - few.bytes) / (1 + 1.0 / kHeadRoom) / 2000;
  EXPECT_NEAR(grown, double(few.per_gaussian), 0.02 * double(few.per_gaussian));
}

}  // namespace
}  // namespace cosplat

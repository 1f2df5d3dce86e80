// Frames held out of training, and how well they are met.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small scenes

constexpr int kSteps = 300;

std::vector<TrainFrame> Frames() { return TargetImages(TrueScene(1), Ring(10, 2.2f)); }

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

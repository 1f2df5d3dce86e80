#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "avatar/model/avatar_model.h"
#include "tests/avatar/training_fixture.h"

namespace cosplat::test {
namespace {

TEST(TrainedRange, IsThatOfTheFrames) {
  std::vector<FlameParams> frames(3);
  frames[0].expression = {1, 2};
  frames[1].expression = {3};
  frames[2].expression = {2, -4};
  frames[0].pose[2] = {0.3f, 0.4f, 0};
  frames[1].pose[2] = {0, 0, 2 * float(M_PI) - 0.1f};  // 0.1 the other way
  const TrainedRange range = RangeOf(frames);
  EXPECT_EQ(range.expression_least, (std::vector<float>{1, -4}));
  EXPECT_EQ(range.expression_most, (std::vector<float>{3, 2}));
  EXPECT_NEAR(range.angle[2], 0.5f, 1e-6f);
  EXPECT_EQ(range.angle[1], 0);
  EXPECT_TRUE(RangeOf({}).expression_least.empty());
}

TEST(TrainedRange, TrainingRecordsIt) {
  const TrackedVideo video = LoadSmallVideo(20, 4);
  Training<> training(video, SmallAvatar(50), ShortRun(1, 50));
  const AvatarModel model = training.subject.Model(training.trainer.state().gaussians);
  ASSERT_TRUE(model.trained_range);
  for (size_t i = 0; i < model.trained_range->expression_least.size(); ++i) {
    float min = 1e9f, max = -1e9f;
    for (const TrackedFrame& frame : video.train) {
      const auto& expression = frame.params.expression;
      const float x = i < expression.size() ? expression[i] : 0;
      min = std::min(min, x);
      max = std::max(max, x);
    }
    EXPECT_EQ(model.trained_range->expression_least[i], min) << i;
    EXPECT_EQ(model.trained_range->expression_most[i], max) << i;
  }
  EXPECT_GT(model.trained_range->angle[2], 0);
}

}  // namespace
}  // namespace cosplat::test

#include "avatar/live/soft_range.h"

#include <gtest/gtest.h>

#include <cmath>

#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

TEST(Ease, IsLevelAtBothEnds) {
  EXPECT_EQ(math::Ease(-3), 0);
  EXPECT_EQ(math::Ease(0), 0);
  EXPECT_FLOAT_EQ(math::Ease(0.5f), 0.5f);
  EXPECT_EQ(math::Ease(1), 1);
  EXPECT_EQ(math::Ease(1e30f), 1);
  EXPECT_NEAR(math::Ease(1e-3f) / 1e-3f, 0, 1e-2f);
  EXPECT_NEAR((1 - math::Ease(1 - 1e-3f)) / 1e-3f, 0, 1e-2f);
}

TEST(SoftClamp, IsTheIdentityWithinAndStopsBeyond) {
  for (float x = -1; x <= 2; x += 0.125f) EXPECT_EQ(math::SoftClamp(x, -1, 2, 0.5f), x);
  float last = -1e9f;
  for (float x = -10; x <= 10; x += 0.01f) {
    const float y = math::SoftClamp(x, -1, 2, 0.5f);
    EXPECT_GE(y, last) << x;
    EXPECT_GE(y, -1.5f);
    EXPECT_LE(y, 2.5f);
    last = y;
  }
  EXPECT_FLOAT_EQ(math::SoftClamp(100, -1, 2, 0.5f), 2.5f);
  EXPECT_FLOAT_EQ(math::SoftClamp(-100, -1, 2, 0.5f), -1.5f);
}

TEST(SoftClamp, HasNoCornerAtTheEdges) {
  const float h = 1e-2f;
  for (const float edge : {-1.0f, 2.0f})
    for (const float side : {-h, h}) {
      const float slope = (math::SoftClamp(edge + side, -1, 2, 0.5f) - edge) / side;
      EXPECT_NEAR(slope, 1, 1e-3f);  // 1 - (h / margin)^2 / 3
    }
}

TrainedRange Trained() {
  TrainedRange range;
  range.expression_least = {-2, 0};
  range.expression_most = {4, 1};
  range.angle = {0, 0, 0.8f, 0, 0};
  return range;
}

FlameParams Face(std::vector<float> expression) {
  FlameParams face;
  face.expression = std::move(expression);
  return face;
}

TEST(SoftRange, TrainedFacesStayAsTheyAre) {
  const SoftRange range(3, Trained());
  FlameParams face = Face({4, 1, 0});
  face.pose = {{{5, -5, 5}, {0, 1.2f, 0}, {0.8f, 0, 0}, {0, 0.9f, 0}, {-0.9f, 0, 0}}};
  const FlameParams before = face;
  EXPECT_FALSE(range.Bring(face));
  EXPECT_EQ(face.expression, before.expression);
  EXPECT_EQ(face.pose, before.pose);
}

TEST(SoftRange, BeyondTheRangeTheMarginIsTheMost) {
  const SoftRange range(3, Trained());
  FlameParams face = Face({50, 50, -50});
  EXPECT_TRUE(range.Bring(face));
  EXPECT_FLOAT_EQ(face.expression[0], 4 + 0.25f * 6);
  EXPECT_FLOAT_EQ(face.expression[1], 1 + SoftRange::kMinMargin);
  EXPECT_FLOAT_EQ(face.expression[2], -SoftRange::kMinMargin) << "not one of training's";
}

TEST(SoftRange, WithoutTrainingsRangeAUsualOneIsTaken) {
  const SoftRange range(1, {});
  FlameParams face = Face({3});
  EXPECT_FALSE(range.Bring(face));
  face.expression[0] = -90;
  EXPECT_TRUE(range.Bring(face));
  EXPECT_FLOAT_EQ(face.expression[0], -4.5f);
}

TEST(SoftRange, JointsKeepTheirAxis) {
  const SoftRange range(0, Trained());
  FlameParams face;
  face.pose[2] = {0, 1.2f, 1.6f};  // 2 rad of 0.8
  EXPECT_TRUE(range.Bring(face));
  const float angle = std::hypot(face.pose[2][1], face.pose[2][2]);
  EXPECT_NEAR(angle, 0.8f + SoftRange::kAngleMargin, 1e-4f);
  EXPECT_NEAR(face.pose[2][1] / face.pose[2][2], 0.75f, 1e-5f);
  EXPECT_EQ(face.pose[2][0], 0);
}

TEST(SoftRange, AWholeTurnMoreIsTheSameJoint) {
  const SoftRange range(0, {});
  FlameParams face;
  face.pose[1] = {0, 2 * float(M_PI) + 0.5f, 0};
  EXPECT_FALSE(range.Bring(face));
  EXPECT_NEAR(face.pose[1][1], 0.5f, 1e-5f);
}

}  // namespace
}  // namespace cosplat

// What a camera's landmarks become: scores, and the head's turn and place beside the neutral one.
#include "apps/cosplat/run/camera_face.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/error.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

constexpr int kWidth = 640, kHeight = 480;

// Points of a face without depth errors: turned by `yaw` (to its left), nodding by `pitch` (down),
// rolled, and moved, in pixels of an image; larger if it is nearer.
CameraFrame FrameOf(double yaw, double pitch, double roll, double right, double scale, double t) {
  CameraFrame frame{"camera", kWidth, kHeight, t, 20, {}};
  for (int i = 0; i < 478; ++i) {
    // On a head of half a sphere, in its own axes: left, up, to the front.
    const double a = 2.4 * i, r = 90 * std::sqrt((i + 0.5) / 478);
    double x = r * std::cos(a), y = r * std::sin(a), z = std::sqrt(100 * 100 - r * r);
    if (i == 33 || i == 263) x = i == 33 ? -45 : 45, y = 20, z = 80;
    const double y1 = y * std::cos(pitch) - z * std::sin(pitch);
    const double z1 = y * std::sin(pitch) + z * std::cos(pitch);
    const double x2 = x * std::cos(yaw) + z1 * std::sin(yaw);
    const double z2 = -x * std::sin(yaw) + z1 * std::cos(yaw);
    const double x3 = x2 * std::cos(roll) - y1 * std::sin(roll);
    const double y3 = x2 * std::sin(roll) + y1 * std::cos(roll);
    frame.points.push_back(
        {kWidth / 2 + scale * x3 + right, kHeight / 2 - scale * y3, -scale * z2});
  }
  return frame;
}

// Calibrated before a camera that it looks into.
CameraFace Calibrated() {
  CameraFace face;
  for (int i = 0; i < CameraFace::kNeutralFrames; ++i)
    EXPECT_FALSE(face.Next(FrameOf(0, 0, 0, 0, 1, i / 30.0)));
  EXPECT_TRUE(face.IsCalibrated());
  return face;
}

TEST(CameraFace, TurnsAboutFlamesAxes) {
  CameraFace face = Calibrated();
  std::optional<JsonFrame> frame = face.Next(FrameOf(0, 0, 0, 0, 1, 1));
  ASSERT_TRUE(frame);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(frame->params.pose[0][size_t(k)], 0, 1e-5);
  EXPECT_EQ(frame->blendshapes->count("jawOpen"), 1u);
  const double turns[][3] = {{0.4, 0, 0}, {0, 0.3, 0}, {0, 0, 0.2}};
  for (int i = 0; i < 3; ++i) {
    // A second later: nothing of the turn before is left by the filter.
    frame = face.Next(FrameOf(turns[i][0], turns[i][1], turns[i][2], 0, 1, 2 + i));
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->sequence, uint64_t(i + 1));
    const auto& turn = frame->params.pose[0];
    EXPECT_NEAR(turn[1], turns[i][0], 1e-3);
    EXPECT_NEAR(turn[0], turns[i][1], 1e-3);
    EXPECT_NEAR(turn[2], turns[i][2], 1e-3);
  }
}

TEST(CameraFace, MovesByTheDistanceOfTheEyes) {
  CameraFace face = Calibrated();
  // 90 px are 90 mm: to the subject's left is to the image's right.
  auto frame = face.Next(FrameOf(0, 0, 0, 30, 1, 1));
  ASSERT_TRUE(frame);
  EXPECT_NEAR(frame->params.translation[0], 0.03, 1e-4);
  EXPECT_NEAR(frame->params.translation[2], 0, 1e-4);
  // A tenth nearer of 0.24 m / tan(31.5 degrees).
  frame = face.Next(FrameOf(0, 0, 0, 0, 1 / 0.9, 3));
  ASSERT_TRUE(frame);
  EXPECT_NEAR(frame->params.translation[2], 0.1 * 0.24 / std::tan(0.55), 1e-3);
}

TEST(CameraFace, IsCalibratedAgain) {
  CameraFace face = Calibrated();
  face.Calibrate();
  for (int i = 0; i < CameraFace::kNeutralFrames; ++i)
    EXPECT_FALSE(face.Next(FrameOf(0.2, 0, 0, 0, 1, 1 + i / 30.0)));
  const auto frame = face.Next(FrameOf(0.2, 0, 0, 0, 1, 3));
  ASSERT_TRUE(frame);
  EXPECT_NEAR(frame->params.pose[0][1], 0, 1e-4);
}

TEST(CameraFace, IsNotWhereThereIsNone) {
  CameraFace face = Calibrated();
  EXPECT_FALSE(face.Next({"camera", kWidth, kHeight, 1, 20, {}}));
  CameraFrame point = FrameOf(0, 0, 0, 0, 1, 2);
  for (auto& p : point.points) p = {5, 5, 5};
  EXPECT_FALSE(face.Next(point));
  ASSERT_TRUE(face.Next(FrameOf(0, 0, 0, 0, 1, 3)));
  // The camera's images became larger: what is neutral in them is not known.
  CameraFrame larger = FrameOf(0, 0, 0, 0, 2, 4);
  larger.width *= 2, larger.height *= 2;
  EXPECT_FALSE(face.Next(larger));
}

TEST(CameraFace, LinesAreChecked) {
  const std::string begin =
      R"({"camera":"c","width":640,"height":480,"time":1500,"milliseconds":20)";
  EXPECT_TRUE(ParseCameraFrame(begin + R"(,"points":[]})").points.empty());
  EXPECT_EQ(ParseCameraFrame(begin + R"(,"points":[]})").seconds, 1.5);
  test::ExpectError([&] { ParseCameraFrame(begin + R"(,"points":[[1,2,3]]})"); },
                    {"points", "478"});
  test::ExpectError([&] { ParseCameraFrame(begin + "}"); }, {"points"});
  test::ExpectError([&] { ParseCameraFrame(begin); }, {"camera's program"});
}

}  // namespace
}  // namespace cosplat

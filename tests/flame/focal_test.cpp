// Another focal length: each head keeps its place and size in the image, its perspective changes.
#include "flame/pose.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "tests/flame/tracked_head.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

TrackedVideo Video() {
  TrackedVideo video;
  video.source = "head";
  video.shape = HeadShape();
  for (int i = 0; i < kHeadFrames; ++i) {
    const HeadFrame head = HeadAt(i);
    TrackedFrame frame;
    frame.camera.width = frame.camera.height = kHeadSide;
    frame.camera.fx = kHeadFocal;
    frame.camera.fy = 0.9f * float(kHeadFocal);
    frame.camera.cx = kHeadCenter[0];
    frame.camera.cy = kHeadCenter[1];
    // Turned by 0.3 about y.
    frame.camera.rotation = {0.955336f, 0, -0.295520f, 0, 1, 0, 0.295520f, 0, 0.955336f};
    frame.camera.translation = {0.02f, -0.01f, 1.5f};
    for (size_t k = 0; k < 3; ++k) {
      frame.params.pose[0][k] = float(head.root[k]);
      frame.params.translation[k] = float(head.translation[k]);
    }
    (i % 3 == 2 ? video.test : video.train).push_back(frame);
  }
  return video;
}

// Of every vertex in the camera.
std::vector<Vec3<double>> InCamera(const FlamePoser<float>& poser, const TrackedFrame& frame) {
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(frame.params), vertices);
  std::vector<Vec3<double>> points;
  for (size_t v = 0; v < vertices.size(); v += 3) {
    Vec3<double> p{};
    for (int r = 0; r < 3; ++r) {
      p[r] = frame.camera.translation[r];
      for (size_t k = 0; k < 3; ++k)
        p[r] += double(frame.camera.rotation[3 * r + k]) * double(vertices[v + k]);
    }
    points.push_back(p);
  }
  return points;
}

TEST(Focal, ChangesPerspectiveAlone) {
  const FlameModel model = HeadModel();
  const FlamePoser<float> poser(model, HeadShape());
  const TrackedVideo before = Video();
  TrackedVideo after = before;
  constexpr double kScale = 0.6;
  ScaleFocal(model, kScale, after);
  EXPECT_TRUE(HasOneStillCamera(after));
  for (const auto set : {&TrackedVideo::train, &TrackedVideo::test})
    for (size_t f = 0; f < (before.*set).size(); ++f) {
      const TrackedFrame &old = (before.*set)[f], &scaled = (after.*set)[f];
      EXPECT_FLOAT_EQ(scaled.camera.fx, float(kScale) * old.camera.fx);
      EXPECT_FLOAT_EQ(scaled.camera.fy, float(kScale) * old.camera.fy);
      EXPECT_EQ(scaled.params.pose, old.params.pose);
      const auto points = InCamera(poser, old), moved = InCamera(poser, scaled);
      double depth = 0;
      for (const auto& p : points) depth += p[2] / double(points.size());
      for (size_t v = 0; v < points.size(); ++v) {
        EXPECT_NEAR(moved[v][0], points[v][0], 1e-6);
        EXPECT_NEAR(moved[v][1], points[v][1], 1e-6);
        EXPECT_NEAR(moved[v][2], kScale * depth + points[v][2] - depth, 1e-6);
      }
    }
  // And back.
  ScaleFocal(model, 1 / kScale, after);
  for (size_t f = 0; f < before.train.size(); ++f)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(
          after.train[f].params.translation[k], before.train[f].params.translation[k], 1e-6);
}

TEST(Focal, OfMovingOrSeveralCamerasIsAnError) {
  const FlameModel model = HeadModel();
  TrackedVideo video = Video();
  video.test.back().camera.translation[0] += 0.01f;
  EXPECT_FALSE(HasOneStillCamera(video));
  ExpectError([&] { ScaleFocal(model, 0.8, video); }, {"head", "--focal-scale", "moves"});
  video = Video();
  video.head_is_fixed = true;
  EXPECT_FALSE(HasOneStillCamera(video));
  EXPECT_FALSE(HasOneStillCamera({}));
}

}  // namespace
}  // namespace cosplat::test

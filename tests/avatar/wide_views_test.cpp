// avatar/train/wide_views.h, on the procedural head filmed from so near that its lower half is in
// no image.
#include "avatar/train/wide_views.h"

#include <gtest/gtest.h>

#include <array>

#include "avatar/play/player.h"
#include "avatar/train/painted_mesh.h"
#include "tests/avatar/made_video.h"

namespace cosplat::test {
namespace {

constexpr int kSide = 192;
constexpr float kDistance = 0.9f;  // metres
constexpr float kFade = 0.04f;

const FlameModel& Model() { return MadeHead().model; }

// The whole head, and the upper half of that image.
Camera Whole(float azimuth = 0) { return procedural::OrbitCamera(azimuth, 0, kDistance, kSide); }
Camera UpperHalf(float azimuth = 0) {
  Camera camera = Whole(azimuth);
  camera.height = kSide / 2;
  return camera;
}

TrainFrame FrameOf(const Camera& camera) {
  return {camera, RenderProceduralHead(MadeHead(), Model().template_vertices, {}, camera)};
}

TEST(WideViews, ShareFallsFromTheBorder) {
  const Camera camera = UpperHalf();
  const auto share = [&](float x, float y, float metres) {
    const float px = metres * camera.fx / kDistance;
    return InFrameShare(camera, {x, y + px, kDistance}, 1);
  };
  EXPECT_EQ(share(10, 10, 0), 1);
  EXPECT_EQ(share(10, kSide / 2, 0), 1);
  EXPECT_NEAR(share(10, kSide / 2, kFade / 2), 0.5f, 1e-5f);
  EXPECT_EQ(share(10, kSide / 2, 1.01f * kFade), 0);
  EXPECT_EQ(share(10, -2 * kSide, 0), 0);
  EXPECT_EQ(InFrameShare(camera, {10, 10, -1}, 1), 0);
  // A head of twice the size.
  EXPECT_GT(InFrameShare(camera, {10, kSide / 2 + kFade * camera.fx / kDistance, kDistance}, 2),
            0.4f);
}

TEST(WideViews, TheBoxHoldsAllFramesAroundTheBody) {
  const TrainFrame frame = FrameOf(UpperHalf());
  const math::Vec3<float> middle =
      math::ToVec3(frame.camera.Center()) + math::ToVec3(&frame.camera.rotation[6]) * kDistance;
  const math::Vec3<float> lower = middle - math::Vec3<float>{0, 0.05f, 0};
  const FilmedBox one = FilmedBoxOf({{&frame, middle}});
  const FilmedBox both = FilmedBoxOf({{&frame, middle}, {&frame, lower}});
  EXPECT_NEAR(one.right - one.left, float(kSide) * kDistance / frame.camera.fx, 1e-5f);
  EXPECT_NEAR(one.bottom, 0, 1e-5f);
  // Where the body is lower, the frame shows more above it.
  EXPECT_NEAR(both.top, one.top - 0.05f, 1e-5f);
  EXPECT_NEAR(both.bottom, one.bottom, 1e-5f);
  // The body may be outside of the image.
  const FilmedBox outside = FilmedBoxOf({{&frame, middle - math::Vec3<float>{0, 0.5f, 0}}});
  EXPECT_NEAR(outside.bottom, -0.5f, 1e-5f);
  // The same lens shows twice as much of what is twice as far.
  TrainFrame far = frame;
  far.camera.translation[2] += kDistance;
  const FilmedBox from_far = FilmedBoxOf({{&frame, middle}, {&far, middle}});
  EXPECT_NEAR(from_far.top, 2 * one.top, 1e-5f);
  EXPECT_NEAR(from_far.right, 2 * one.right, 1e-5f);
}

TEST(WideViews, AreOfFramesWhoseBorderCutsThePersonOff) {
  EXPECT_TRUE(ReachesBorder(FrameOf(UpperHalf())));
  TrainFrame clear = FrameOf(Whole());
  for (int y = 0; y < kSide; ++y)
    for (const int x : {0, kSide - 1}) clear.target.data[4 * size_t(y * kSide + x) + 3] = 0;
  for (int x = 0; x < kSide; ++x)
    for (const int y : {0, kSide - 1}) clear.target.data[4 * size_t(y * kSide + x) + 3] = 0;
  EXPECT_FALSE(ReachesBorder(clear));
}

// Inside nothing is taught; beyond it the border's colours fade out, and far beyond is nothing.
TEST(WideViews, ContinueTheBorderAndFadeOut) {
  const TrainFrame frame = FrameOf(UpperHalf());
  const math::Vec3<float> middle =
      math::ToVec3(frame.camera.Center()) + math::ToVec3(&frame.camera.rotation[6]) * kDistance;
  const BodyInFrame body{&frame, middle};
  const TrainFrame wide = ToWideView(body, FilmedBoxOf({body}), 1);
  ASSERT_EQ(wide.camera.width, frame.camera.width);
  ASSERT_EQ(wide.camera.height, frame.camera.height);
  EXPECT_LT(wide.camera.fx, frame.camera.fx);
  size_t within = 0, fading = 0, empty = 0;
  for (int y = 0; y < wide.camera.height; ++y)
    for (int x = 0; x < wide.camera.width; ++x) {
      const size_t pixel = size_t(y * wide.camera.width + x);
      // The same ray in the frame, px.
      const float u =
          (float(x) + 0.5f - wide.camera.cx) / wide.camera.fx * frame.camera.fx + frame.camera.cx;
      const float v =
          (float(y) + 0.5f - wide.camera.cy) / wide.camera.fy * frame.camera.fy + frame.camera.cy;
      const bool inside = u > 0.01f && v > 0.01f && u < kSide - 0.01f && v < kSide / 2 - 0.01f;
      const float below = (v - kSide / 2) * kDistance / frame.camera.fy;  // metres
      if (inside) EXPECT_NE(wide.ignored.data[pixel], 0);
      within += inside;
      if (inside || below < 0.001f) continue;
      EXPECT_EQ(wide.ignored.data[pixel], 0);
      const int alpha = wide.target.data[4 * pixel + 3];
      if (below > kFade) {
        EXPECT_EQ(alpha, 0);
        ++empty;
      } else if (std::abs(u - kSide / 2) < 10) {  // below the face
        EXPECT_NEAR(alpha, 255 * InFrameShare(frame.camera, {u, v, kDistance}, 1), 3);
        for (int c = 0; c < 3 && alpha > 0; ++c)
          EXPECT_NEAR(wide.target.at(x, y, c), frame.target.at(kSide / 2, kSide / 2 - 1, c), 60);
        ++fading;
      }
    }
  EXPECT_GT(within, 1000u);
  EXPECT_GT(fading, 30u);
  EXPECT_GT(empty, 500u);
}

size_t FirstGaussians(std::vector<TrainFrame> frames) {
  AvatarSettings settings = SmallAvatar(1500);
  settings.virtual_views = 0.2f;
  AvatarSubject subject(Model(), VideoOf(std::move(frames)), settings);
  return subject.InitialGaussians(0, Basis::kDcsh, 1).size();
}

// Nothing begins where no frame shows the head, but where a single one does, and where a wrong
// track sees nothing of it.
TEST(WideViews, NothingBeginsBeyondAllImages) {
  const TrainFrame whole = FrameOf(Whole()), upper = FrameOf(UpperHalf());
  std::vector<TrainFrame> frames(50, upper);
  EXPECT_LT(FirstGaussians(frames), 1400u);
  EXPECT_EQ(FirstGaussians(std::vector<TrainFrame>(3, whole)), 1500u);
  frames[1] = whole;
  EXPECT_EQ(FirstGaussians(frames), 1500u);
  TrainFrame beside = whole;
  beside.camera.cx += 100 * kSide;
  EXPECT_EQ(FirstGaussians({beside, beside}), 1500u);
  beside.camera = whole.camera;
  beside.camera.translation[2] -= 2 * kDistance;  // behind the camera
  EXPECT_EQ(FirstGaussians({beside, beside}), 1500u);
  EXPECT_EQ(FirstGaussians({whole, beside, whole}), 1500u);
}

// Trained on images that end at half of the head's height: nothing is far below them.
TEST(WideViews, LeaveNothingFarBeyondTheImages) {
  std::vector<TrainFrame> frames;
  for (int f = 0; f < 8; ++f) frames.push_back(FrameOf(UpperHalf(0.02f * float(f % 5 - 2))));
  const TrackedVideo video = VideoOf(std::move(frames));
  std::array<double, 2> below{}, within{}, count{};
  for (const bool with : {false, true}) {
    AvatarSettings settings = SmallAvatar(1500);
    settings.virtual_views = with ? 0.5f : 0.0f;
    settings.iterations = 500;
    AvatarSubject subject(Model(), video, settings);
    const TrainSettings train = ShortRun(500, 3000);
    Gaussians first = subject.InitialGaussians(train.degree, Basis::kDcsh, 1);
    count[with] = double(first.size());
    Trainer trainer(train, subject, std::move(first));
    while (trainer.iteration() < train.iterations) trainer.Step();
    Player player(subject.Model(trainer.TakeGaussians()), Model());
    RenderedImage image;
    player.RenderOver({}, Whole(), {0, 0, 0}, image);
    const int far = kSide / 2 + int(1.5f * kFade * Whole().fy / kDistance);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const double alpha = 1 - image.transmittance[size_t(y) * kSide + size_t(x)];
        if (y < kSide / 2) within[with] += alpha;
        if (y >= far) below[with] += alpha;
      }
  }
  EXPECT_LT(below[1], 0.1 * below[0]);
  EXPECT_NEAR(within[1] / within[0], 1, 0.03);
  EXPECT_LT(count[1], 0.9 * count[0]);  // none are where no frame shows them
}

}  // namespace
}  // namespace cosplat::test

// apps/viewer/render_worker.h and capture.h: what runs beside the window, and what is kept.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "apps/viewer/capture.h"
#include "apps/viewer/live_face.h"
#include "apps/viewer/render_worker.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/viewer_fixture.h"

namespace cosplat::test {
namespace {

using viewer::FinishedImage;
using viewer::LiveFace;
using viewer::RenderWorker;
using viewer::Shot;
using viewer::Stage;
using viewer::VideoRecorder;
using viewer::View;

Shot SceneShot(int width) {
  Shot shot;
  shot.camera = viewer::OrbitCamera(SmallScene().start).At(width, 16);
  return shot;
}

// Until nothing is drawn any more; the newest image.
FinishedImage Newest(RenderWorker& worker) {
  while (worker.Busy()) std::this_thread::yield();
  FinishedImage picture;
  EXPECT_TRUE(worker.TakeImage(picture));
  EXPECT_FALSE(worker.TakeImage(picture));
  return picture;
}

TEST(RenderWorker, TheLastJobCounts) {
  Stage stage(SmallScene());
  std::atomic<int> finished = 0;
  RenderWorker worker(stage, [&] { ++finished; });
  for (int width = 1; width <= 40; ++width) worker.Start({SceneShot(width), 1, width});
  const FinishedImage picture = Newest(worker);
  EXPECT_EQ(picture.image.width, 40);
  EXPECT_EQ(picture.job.input_ns, 40);
  EXPECT_GT(picture.milliseconds, 0);
  EXPECT_LE(finished, 40);
}

TEST(RenderWorker, SaysWhatIsWrongAndGoesOn) {
  Stage stage(SmallScene());
  RenderWorker worker(stage, [] {});
  Shot wire = SceneShot(8);
  wire.view = View::kWire;
  worker.Start({wire, 1, 0});
  const FinishedImage broken = Newest(worker);
  EXPECT_TRUE(broken.image.empty());
  EXPECT_NE(broken.problem.find("wire is only available for avatars"), std::string::npos);
  worker.Start({SceneShot(8), 1, 0});
  const FinishedImage picture = Newest(worker);
  EXPECT_EQ(picture.problem, "");
  EXPECT_EQ(picture.image.width, 8);
}

TEST(RenderWorker, EndsWithAJobWaiting) {
  Stage stage(SmallScene());
  int finished = 0;
  {
    RenderWorker worker(stage, [&] { ++finished; });
    for (int i = 0; i < 3; ++i) worker.Start({SceneShot(64 + i), 1, 0});
  }
  EXPECT_LE(finished, 3);
  Image8 image;  // the stage is free again
  stage.Draw(SceneShot(80), image);
  EXPECT_EQ(image.width, 80);
}

TEST(Capture, NamesAreNew) {
  const TemporaryFolder folder;
  const std::string path = viewer::CapturePath(folder / "images", ".png");
  EXPECT_EQ(path.rfind(folder / "images/cosplat_", 0), 0u);
  WriteImage(path, Image8(4, 4, 4));
  const std::string next = viewer::CapturePath(folder / "images", ".png");
  EXPECT_NE(next, path);
  EXPECT_FALSE(std::filesystem::exists(next));
}

TEST(Capture, VideosShowEachImageForItsTime) {
  const TemporaryFolder folder;
  VideoRecorder recorder(folder / "a.mp4", 33, 32);
  EXPECT_EQ(recorder.width(), 32);
  Image8 white(32, 32, 4, 255), black(33, 33, 4, 0);
  recorder.Offer(white, 0.001);  // frame 0
  recorder.Offer(black, 0.01);   // within frame 0, which is there
  recorder.Offer(black, 0.1);    // frames 1 and 2
  recorder.Finish();
  EXPECT_EQ(recorder.frames(), 3);
  VideoReader video(folder / "a.mp4");
  ASSERT_EQ(video.frame_count(), 3);
  EXPECT_GT(video.ReadFrame(0).at(16, 16, 1), 240);
  EXPECT_LT(video.ReadFrame(2).at(16, 16, 1), 15);
}

TEST(Capture, AVideoThatWasGivenUpLeavesNothing) {
  const TemporaryFolder folder;
  { VideoRecorder(folder / "a.mp4", 32, 32).Offer(Image8(32, 32, 4), 0); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  ExpectError([&] { VideoRecorder(folder / "a.mp4", 1, 32); }, {"a.mp4", "0x32"});
}

constexpr int64_t kMillisecond = 1'000'000;

// Gives frames at 100 and 200 ms, then one that is no face's.
class ThreeFrames : public LiveSource {
 public:
  bool Poll(int64_t now_ns, LiveFrame& out) override {
    if (now_ns < 100 * kMillisecond * (given_ + 1) || given_ == 3) return false;
    ++given_;
    out.params.expression = {given_ == 3 ? 1e6f : 0.5f * float(given_)};
    out.time_ns = 100 * kMillisecond * given_;
    return true;
  }
  bool Ended() const override { return given_ == 3; }
  LiveCounts Counts() const override { return {}; }
  std::string Description() const override { return "three frames"; }

 private:
  int given_ = 0;
};

TEST(LiveFace, FollowsTheRuleForBadFrames) {
  FlameParams rest;
  rest.translation = {1, 2, 3};
  rest.expression = {0, 0};
  LiveFace face(std::make_unique<ThreeFrames>(), rest, {});
  face.Advance(50 * kMillisecond);
  EXPECT_EQ(face.Face().translation, rest.translation);
  EXPECT_EQ(face.input_ns(), 50 * kMillisecond);
  face.Advance(210 * kMillisecond);
  face.Advance(220 * kMillisecond);  // of the second frame
  EXPECT_EQ(face.input_ns(), 200 * kMillisecond);
  face.Advance(310 * kMillisecond);
  EXPECT_TRUE(face.Ended());
  EXPECT_EQ(face.guard().counts().out_of_range, 1u);
  EXPECT_LE(face.Face().expression[0], 1);
  face.Advance(9000 * kMillisecond);  // long gone to rest
  EXPECT_EQ(face.Face().expression, rest.expression);
  EXPECT_EQ(face.input_ns(), 9000 * kMillisecond);
}

// A head that is turned, and further back, than at rest: by 0.1 per 40 ms.
class Turning : public LiveSource {
 public:
  bool Poll(int64_t now_ns, LiveFrame& out) override {
    const float turned = 0.1f * float(now_ns / (40 * kMillisecond));
    out.params.expression = {};
    out.params.pose[0] = {0, turned, 0};
    out.params.pose[1] = {turned, 0, 0};
    out.params.translation = {0, 0, -turned};
    out.time_ns = now_ns;
    return true;
  }
  bool Ended() const override { return false; }
  LiveCounts Counts() const override { return {}; }
  std::string Description() const override { return "turning"; }
};

TEST(LiveFace, IsCalibratedToTheHeadAsItIs) {
  FlameParams rest;
  rest.translation = {1, 2, 3};
  rest.pose[0] = {0, 0.3f, 0};
  LiveFace face(std::make_unique<Turning>(), rest, {});
  face.Calibrate();  // nothing has come yet
  face.Advance(40 * kMillisecond);
  EXPECT_NEAR(face.Face().pose[0][1], 0.1f, 1e-4f);
  face.Calibrate();
  face.Advance(80 * kMillisecond);
  const FlameParams turned = face.Face();
  EXPECT_NEAR(turned.pose[0][1], 0.4f, 1e-4f);
  EXPECT_NEAR(turned.pose[1][0], 0.1f, 1e-4f);
  EXPECT_NEAR(turned.translation[0], 1, 1e-4f);
  EXPECT_NEAR(turned.translation[2], 2.9f, 1e-4f);
  face.Calibrate();  // beside what came, not what was shown
  face.Advance(120 * kMillisecond);
  EXPECT_NEAR(face.Face().pose[0][1], 0.4f, 1e-4f);
  EXPECT_NEAR(face.frames_per_second(), 25, 0.1);
}

}  // namespace
}  // namespace cosplat::test

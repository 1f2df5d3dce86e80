// Parameters without images.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/flame/track_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

using Json = nlohmann::json;

TEST(TrackedVideo, DrivingNeedsNoImages) {
  const Imavatar imavatar;
  const TrackedVideo video = LoadDrivingSequence(imavatar.Write());
  EXPECT_EQ(video.train.size() + video.test.size(), 10u);
  EXPECT_FALSE(video.train[0].has_image);
  EXPECT_EQ(video.train[0].camera.width, 512);
  ExpectError([&] { LoadTrackedImage(video, video.train[0]); }, {"frame 1", "has no image"});
  ExpectError([&] { imavatar.Load(); }, {imavatar.folder.path(), "image", "video.mp4"});
  const Vhap vhap;
  std::filesystem::remove_all(vhap.folder / "images");
  EXPECT_EQ(LoadDrivingSequence(vhap.Write()).train.size(), 8u);
  ExpectError([&] { vhap.Load(); }, {"10 of 10", "images/0.png is missing"});
}

TEST(TrackedVideo, DrivingSequences) {
  const TemporaryFolder folder;
  Npz npz;
  npz.Add("expr", {4, 2}, std::vector<float>{1, 2, 3, 4, 5, NAN, 7, 8});
  npz.Add("rot", {4, 3}, std::vector<float>{0, 0, 0, .1f, .2f, .3f, 0, 0, 0, 0, 0, 0});
  npz.Add("tra", {4, 3}, std::vector<float>{0, 0, -1, 0, 0, -2, 0, 0, -3, 0, 0, -4});
  npz.Add("eye_rot", {4, 3}, std::vector<float>{0, 0, 0, .4f, .5f, 0, 0, 0, 0, 0, 0, 0});
  npz.Add("fx", {1, 1}, std::vector<float>{900});
  npz.Add("resolutions", {1, 2}, std::vector<int32_t>{300, 200});
  npz.Add("fps", {}, std::vector<float>{30});
  npz.Write(folder / "s.npz");
  const TrackedVideo video = LoadDrivingSequence(folder / "s.npz");
  EXPECT_EQ(video.layout, "npz");
  EXPECT_EQ(video.frames_per_second, 30);
  EXPECT_TRUE(video.train.empty());
  ASSERT_EQ(video.test.size(), 3u);
  ASSERT_EQ(video.skipped.size(), 1u);
  EXPECT_EQ(video.skipped[0].name, "2");
  const TrackedFrame& frame = video.test[1];
  EXPECT_EQ(frame.camera.width, 200);
  EXPECT_EQ(frame.camera.height, 300);
  EXPECT_FLOAT_EQ(frame.camera.fx, 900);
  EXPECT_FLOAT_EQ(frame.camera.cx, 100);
  EXPECT_FLOAT_EQ(frame.camera.rotation[8], -1);  // OpenGL's camera looks along -z
  EXPECT_FALSE(frame.has_image);
  EXPECT_EQ(frame.params.expression, (std::vector<float>{3, 4}));
  EXPECT_FLOAT_EQ(frame.params.translation[2], -2);
  EXPECT_FLOAT_EQ(frame.params.pose[0][1], .2f);
  EXPECT_FLOAT_EQ(frame.params.pose[3][1], .5f);
  EXPECT_FLOAT_EQ(frame.params.pose[4][0], .4f);
  ExpectError([&] { LoadTrackedVideo(folder / "s.npz", {}); }, {"s.npz", "no images"});
  const auto refuse = [&](const char* name, double value) {
    Npz changed = npz;
    changed.Add(name, NpyArray{{2}, {value, value}, "<f4"});
    changed.Write(folder / "c.npz");
    ExpectError([&] { LoadDrivingSequence(folder / "c.npz"); }, {"c.npz", name});
  };
  refuse("resolutions", 3e9);  // not an int
  refuse("fx", INFINITY);
  refuse("cx", NAN);
  npz.Add("rot", {3, 3}, std::vector<float>(9, 0.f));
  npz.Write(folder / "s.npz");
  ExpectError([&] { LoadDrivingSequence(folder / "s.npz"); }, {"rot", "[3, 3]", "[4, 3]"});
  Npz empty;
  empty.Add("expr", {0, 65}, std::vector<float>{});
  empty.Write(folder / "e.npz");
  ExpectError([&] { LoadDrivingSequence(folder / "e.npz"); }, {"e.npz", "no frames"});
  Npz other;
  other.Add("shape", {1}, std::vector<float>{1});
  other.Write(folder / "o.npz");
  ExpectError([&] { LoadDrivingSequence(folder / "o.npz"); }, {"o.npz", "expr", "missing"});
}

// flame_param.npz, which GaussianAvatars keeps beside a point cloud.
TEST(TrackedVideo, GaussianAvatarsMotionIsADrivingSequence) {
  const TemporaryFolder folder;
  Npz npz;
  npz.Add("shape", {2}, std::vector<float>{0.5f, -0.25f});
  npz.Add("expr", {3, 2}, std::vector<float>{1, 2, 0, 0, 3, 4});
  npz.Add("rotation", {3, 3}, std::vector<float>{.1f, .2f, .3f, 0, 0, 0, .4f, 0, 0});
  npz.Add("jaw_pose", {3, 3}, std::vector<float>{.7f, 0, 0, 0, 0, 0, 0, 0, 0});
  npz.Add("eyes_pose",
          {3, 6},
          std::vector<float>{.1f, .2f, .3f, .4f, .5f, .6f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  npz.Add("translation", {3, 3}, std::vector<float>{0, 0, -1, 0, 0, 0, 0, 0, -2});
  npz.Add("static_offset", {1, 2, 3}, std::vector<float>{0, 0, 0, 0, 0, .5f});
  npz.Add("dynamic_offset", {3, 2, 3}, std::vector<float>(18, 0.f));
  npz.Write(folder / "flame_param.npz");
  const TrackedVideo video = LoadDrivingSequence(folder / "flame_param.npz");
  EXPECT_EQ(video.shape, (std::vector<float>{0.5f, -0.25f}));
  EXPECT_EQ(video.static_offset.size(), 6u);
  ASSERT_EQ(video.test.size(), 2u);  // the second row is no frame
  EXPECT_EQ(video.skipped.at(0).name, "1");
  const FlameParams& params = video.test[0].params;
  EXPECT_EQ(params.expression, (std::vector<float>{1, 2}));
  EXPECT_FLOAT_EQ(params.pose[0][2], .3f);
  EXPECT_FLOAT_EQ(params.pose[2][0], .7f);
  EXPECT_FLOAT_EQ(params.pose[3][0], .1f);  // left, then right
  EXPECT_FLOAT_EQ(params.pose[4][0], .4f);
  EXPECT_FLOAT_EQ(params.translation[2], -1);
  npz.Add("dynamic_offset", {3, 2, 3}, std::vector<float>(18, .1f));
  npz.Write(folder / "flame_param.npz");
  ExpectError([&] { LoadDrivingSequence(folder / "flame_param.npz"); }, {"dynamic_offset"});
}

}  // namespace
}  // namespace cosplat::test

// Tracked videos: what all layouts have, and IMavatar's.
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

TEST(TrackedVideo, ImavatarCamerasAreOpenCvInMetres) {
  Imavatar set;
  set.WriteImages(4);
  const TrackedVideo video = set.Load();
  EXPECT_EQ(video.layout, "imavatar");
  EXPECT_EQ(video.shape, (std::vector<float>{0.5f, -0.25f}));
  const TrackedFrame& frame = video.train[2];
  EXPECT_EQ(frame.name, "3");
  EXPECT_EQ(frame.timestep, 2);
  EXPECT_EQ(frame.camera.width, kWidth);
  EXPECT_FLOAT_EQ(frame.camera.fx, 64);  // |-2| * 32
  EXPECT_FLOAT_EQ(frame.camera.fy, 72);
  EXPECT_FLOAT_EQ(frame.camera.cx, 16);
  EXPECT_FLOAT_EQ(frame.camera.cy, 10.8f);
  const auto [angle, t] = PoseOf(2);
  EXPECT_NEAR(frame.camera.translation[0], t[0], 1e-7);  // divided by the mesh's enlargement
  EXPECT_NEAR(frame.camera.translation[1], -t[1], 1e-7);
  EXPECT_NEAR(frame.camera.translation[2], -t[2], 1e-7);  // in front: positive depth
  EXPECT_NEAR(frame.camera.rotation[0], std::cos(angle), 1e-7);
  EXPECT_NEAR(frame.camera.rotation[4], -1, 1e-7);
  EXPECT_NEAR(frame.camera.rotation[8], -std::cos(angle), 1e-7);
  EXPECT_NEAR(frame.params.pose[0][0], 0.2, 1e-6);
  EXPECT_NEAR(frame.params.pose[2][1], 0.07 + 0.2, 1e-6);
  EXPECT_NEAR(frame.params.pose[4][2], 0.14 + 0.2, 1e-6);
  EXPECT_EQ(frame.params.translation, (std::array<float, 3>{0, 0, 0}));
}

TEST(TrackedVideo, OldIntrinsicsArePixelsAt512) {
  Imavatar set;
  set.WriteImages(4);
  const Camera now = set.Load().train[0].camera;
  set.json["intrinsics"] = {-2.0 * 512, 3.0 * 512, 0.5 * 512, 0.45 * 512};
  const Camera old = set.Load().train[0].camera;
  EXPECT_FLOAT_EQ(now.fx, old.fx);
  EXPECT_FLOAT_EQ(now.fy, old.fy);
  EXPECT_FLOAT_EQ(now.cx, old.cx);
  EXPECT_FLOAT_EQ(now.cy, old.cy);
}

TEST(TrackedVideo, BothLayoutsGiveTheSame) {
  Imavatar imavatar;
  imavatar.WriteImages(4);
  Vhap vhap;
  const std::vector<TrackedFrame> a = AllFrames(imavatar.Load()), b = AllFrames(vhap.Load());
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_FLOAT_EQ(a[i].camera.fx, b[i].camera.fx);
    EXPECT_FLOAT_EQ(a[i].camera.cy, b[i].camera.cy);
    for (int k = 0; k < 9; ++k) EXPECT_NEAR(a[i].camera.rotation[k], b[i].camera.rotation[k], 1e-6);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(a[i].camera.translation[k], b[i].camera.translation[k], 1e-6);
    EXPECT_EQ(a[i].params.expression, b[i].params.expression);
    for (int j = 0; j < kFlameJoints; ++j)
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[i].params.pose[j][k], b[i].params.pose[j][k], 1e-6);
  }
}

TEST(TrackedVideo, Splits) {
  Imavatar set;
  set.WriteImages(4);
  const auto sizes = [](const TrackedVideo& video) {
    return std::pair(video.train.size(), video.test.size());
  };
  EXPECT_EQ(sizes(set.Load()), std::pair(size_t(8), size_t(2)));  // a fifth
  EXPECT_EQ(set.Load().test[0].name, "9");                        // the last ones
  EXPECT_EQ(sizes(set.Load({.test_frames = 0})), std::pair(size_t(10), size_t(0)));
  set.json["test_frames"] = 3;
  EXPECT_EQ(sizes(set.Load()), std::pair(size_t(7), size_t(3)));
  EXPECT_EQ(sizes(set.Load({.test_frames = 4})), std::pair(size_t(6), size_t(4)));
  ExpectError([&] { set.Load({.test_frames = 10}); }, {"10 of 10 frames"});
  Vhap vhap(10, 7);
  EXPECT_EQ(sizes(vhap.Load()), std::pair(size_t(7), size_t(3)));
  EXPECT_EQ(sizes(vhap.Load({.test_frames = 1})), std::pair(size_t(9), size_t(1)));
  EXPECT_EQ(vhap.Load({.test_frames = 1}).test[0].timestep, 9);
  std::filesystem::rename(vhap.folder / "transforms_test.json",
                          vhap.folder / "transforms_val.json");
  const TrackedVideo val = LoadTrackedVideo(vhap.folder.path(), {});
  EXPECT_EQ(val.test.size(), 3u);
}

TEST(TrackedVideo, AlphaComesFromTheImageOrElseTheMask) {
  Imavatar rgba;
  rgba.WriteImages(4);
  rgba.WriteMasks();
  TrackedVideo video = rgba.Load();
  Image8 image = LoadTrackedImage(video, video.train[0]);
  EXPECT_EQ(image.at(0, 0, 3), 0);
  EXPECT_EQ(image.at(31, 0, 3), 255);
  // Alpha that is opaque everywhere says nothing.
  WriteImage(video.train[0].image_path, Image8(kWidth, kHeight, 4, 255));
  image = LoadTrackedImage(video, video.train[0]);
  EXPECT_EQ(image.at(3, 3, 3), 255);
  EXPECT_EQ(image.at(20, 3, 3), 0);
  Imavatar rgb;
  rgb.WriteImages(3);
  video = rgb.Load();  // neither
  EXPECT_EQ(LoadTrackedImage(video, video.train[0]).channels, 3);
  rgb.WriteMasks();
  video = rgb.Load();
  image = LoadTrackedImage(video, video.train[1]);
  EXPECT_EQ(image.channels, 4);
  EXPECT_EQ(image.at(3, 3, 0), 20);
  EXPECT_EQ(image.at(3, 3, 3), 255);
  EXPECT_EQ(image.at(20, 3, 3), 0);
  // Half the size: cameras and images alike.
  video = rgb.Load({.resolution = 2});
  EXPECT_EQ(video.train[1].camera.width, kWidth / 2);
  EXPECT_FLOAT_EQ(video.train[1].camera.fx, 32);
  image = LoadTrackedImage(video, video.train[1]);
  EXPECT_EQ(image.width, kWidth / 2);
  EXPECT_EQ(image.at(3, 3, 3), 255);
  EXPECT_EQ(image.at(12, 3, 3), 0);
}

TEST(TrackedVideo, ImagesIsPreferredToImage) {
  Imavatar set;
  set.WriteImages(4, "image");
  set.WriteImages(3, "images");
  EXPECT_NE(set.Load().train[0].image_path.find("/images/"), std::string::npos);
}

TEST(TrackedVideo, AVideoFileServesAsImages) {
  Imavatar set(5);
  VideoWriter writer(set.folder / "video.mp4", kWidth, kHeight, 25);
  for (int i = 1; i <= 4; ++i) writer.Write(TestImage(4 * i, 3));
  writer.Finish();
  set.WriteMasks();
  const TrackedVideo video = set.Load({.test_frames = 1});
  EXPECT_EQ(video.train.size(), 3u);
  ASSERT_EQ(video.skipped.size(), 1u);  // the fifth frame of four
  EXPECT_NE(video.skipped[0].reason.find("video.mp4 has 4 frames"), std::string::npos);
  EXPECT_EQ(video.train[1].camera.width, kWidth);
  const Image8 image = LoadTrackedImage(video, video.train[1]);
  EXPECT_NEAR(image.at(3, 3, 1), 80, 6);
  EXPECT_EQ(image.at(3, 3, 3), 255);
  EXPECT_EQ(image.at(30, 3, 3), 0);
}

TEST(TrackedVideo, BadFramesAreSkippedAndListed) {
  Imavatar set(15);
  set.WriteImages(3);
  set.WriteMasks();
  std::filesystem::remove(set.folder / "image/1.png");
  std::filesystem::remove(set.folder / "mask/2.png");
  set.json["frames"][2]["pose"][4] = nullptr;  // what NaN becomes
  set.json["frames"][3]["expression"].push_back(1);
  set.json["frames"][4]["world_mat"][0][0] = 3;
  const TrackedVideo video = set.Load();
  EXPECT_EQ(video.train.size() + video.test.size(), 10u);
  const char* reasons[] = {"image/1.png is missing",
                           "mask/2.png is missing",
                           "pose[4] is not finite",
                           "expression has 4 numbers, expected 3",
                           "not orthonormal"};
  ASSERT_EQ(video.skipped.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(video.skipped[i].name, std::to_string(i + 1));
    EXPECT_NE(video.skipped[i].reason.find(reasons[i]), std::string::npos)
        << video.skipped[i].reason;
  }
  set.json["frames"][5]["pose"].push_back(1);
  ExpectError([&] { set.Load(); }, {"6 of 15", "image/1.png is missing"});
}

TEST(TrackedVideo, NumbersThatNoHeadHasAreSkipped) {
  Imavatar set(15);
  set.WriteImages(4);
  set.json["frames"][1]["expression"][0] = 100;
  set.json["frames"][2]["pose"][6] = 12;  // the jaw, in degrees
  set.json["frames"][3]["world_mat"][0][3] = 1e6;
  const TrackedVideo video = set.Load();
  EXPECT_EQ(video.train.size() + video.test.size(), 12u);
  const char* reasons[] = {"100 standard deviations", "the jaw by 12", "at a distance of 2.5e+05"};
  ASSERT_EQ(video.skipped.size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_NE(video.skipped[i].reason.find(reasons[i]), std::string::npos)
        << video.skipped[i].reason;
  for (Json& frame : set.json["frames"])
    for (Json& angle : frame["pose"]) angle = 57.3 * angle.get<double>();
  ExpectError([&] { set.Load(); }, {"are the angles in degrees?"});
  Vhap vhap;
  vhap.params[3].Add("expr", {1, 2}, std::vector<float>{0.1f, 0.2f});
  const TrackedVideo other = vhap.Load();
  ASSERT_EQ(other.skipped.size(), 1u);
  EXPECT_NE(other.skipped[0].reason.find("has 2 expression coefficients, other frames 3"),
            std::string::npos)
      << other.skipped[0].reason;
}

TEST(TrackedVideo, ImavatarFramesInTheOrderOfText) {
  Imavatar set(12);
  set.WriteImages(4);
  const TrackedVideo right = set.Load();
  Json& frames = set.json["frames"];
  std::sort(frames.begin(), frames.end(), [](const Json& a, const Json& b) {
    return a["file_path"].get<std::string>() < b["file_path"].get<std::string>();
  });
  ASSERT_EQ(frames[1]["file_path"], "./image/10");
  const TrackedVideo sorted = set.Load();
  ASSERT_EQ(sorted.notes.size(), right.notes.size() + 1);
  for (const auto of : {&TrackedVideo::train, &TrackedVideo::test}) {
    ASSERT_EQ((sorted.*of).size(), (right.*of).size());
    for (size_t i = 0; i < (right.*of).size(); ++i) {
      EXPECT_EQ((sorted.*of)[i].name, (right.*of)[i].name);
      EXPECT_EQ((sorted.*of)[i].timestep, (right.*of)[i].timestep);
    }
  }
}

TEST(TrackedVideo, SizesThatDisagree) {
  Imavatar set;
  set.WriteImages(3);
  set.WriteMasks();
  WriteImage(set.folder / "mask/4.png", Image8(kWidth, kHeight - 1, 1));
  WriteImage(set.folder / "image/5.png", Image8(kWidth, kHeight + 9, 3));
  const TrackedVideo video = set.Load();
  ASSERT_EQ(video.skipped.size(), 2u);
  EXPECT_NE(video.skipped[0].reason.find("32x23, its image 32x24"), std::string::npos);
  EXPECT_NE(video.skipped[1].reason.find("32x33, its camera 32x24"), std::string::npos);
  // What changes after loading is an error.
  WriteImage(set.folder / "mask/1.png", Image8(kWidth, kHeight - 1, 1));
  ExpectError([&] { LoadTrackedImage(video, video.train[0]); }, {"mask/1.png", "32x23", "32x24"});
  std::filesystem::remove(set.folder / "mask/2.png");
  ExpectError([&] { LoadTrackedImage(video, video.train[1]); }, {"mask/2.png", "No such file"});
  WriteFileAtomically(set.folder / "image/3.png", "broken");
  ExpectError([&] { LoadTrackedImage(video, video.train[2]); }, {"image/3.png"});
}

TEST(TrackedVideo, AImageInMemoryNeedsNoFile) {
  TrackedFrame frame;
  frame.image_path = "/nowhere.png";
  frame.image = std::make_shared<const Image8>(3, 2, 4, uint8_t(7));
  const Image8 image = LoadTrackedImage({}, frame);
  EXPECT_EQ(image.channels, 4);
  EXPECT_EQ(image.data, frame.image->data);
}

TEST(TrackedVideo, ImavatarJsonErrorsNameTheField) {
  const struct {
    const char* pointer;
    Json value;
    std::vector<std::string> parts;
  } cases[] = {
      {"/intrinsics", {1, 2, 3}, {"flame_params.json", "intrinsics", "3 numbers, expected 4"}},
      {"/intrinsics", {0, 2, .5, .5}, {"intrinsics", "focal length of zero"}},
      {"/shape_params", "none", {"shape_params", "\"none\"", "an array"}},
      {"/shape_params/1", nullptr, {"shape_params[1]", "null", "finite"}},
      {"/frames", 1, {"frames", "an array"}},
      {"/frames", Json::array(), {"contains no frames"}},
      {"/frames/3/pose/2", "x", {"frames[3].pose[2]", "\"x\""}},
      {"/frames/3/expression", 4, {"frames[3].expression", "an array"}},
      {"/frames/3/file_path", nullptr, {"frames[3].file_path", "a string"}},
      {"/frames/3", Json::object(), {"frames[3].file_path", "missing"}},
      {"/test_frames", 2.5, {"test_frames", "2.5", "an integer"}},
      {"/test_frames", -3, {"test frames", "-3"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.pointer);
    Imavatar set;
    set.WriteImages(4);
    set.json[Json::json_pointer(c.pointer)] = c.value;
    ExpectError([&] { set.Load(); }, c.parts);
  }
}

TEST(TrackedVideo, NothingThereIsAnError) {
  const TemporaryFolder folder;
  ExpectError([&] { LoadTrackedVideo(folder / "none", {}); }, {"none", "does not exist"});
  ExpectError([&] { LoadTrackedVideo(folder.path(), {}); }, {"flame_params.json", "VHAP"});
  const Imavatar set;
  ExpectError([&] { set.Load({.resolution = 0}); }, {"resolution", "0"});
}

}  // namespace
}  // namespace cosplat::test

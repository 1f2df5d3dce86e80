#include "flame/track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;
using Json = nlohmann::json;

constexpr int kWidth = 32, kHeight = 24;

// A pose of the test's camera: cam_from_world with OpenGL's axes.
struct GlPose {
  double angle;  // about y
  std::array<double, 3> translation;
};
GlPose PoseOf(int i) { return {0.1 * i, {0.01 * i, -0.02, -1.2 - 0.01 * i}}; }

Image8 Image(int index, int channels) {
  Image8 image(kWidth, kHeight, channels, uint8_t(10 * index));
  if (channels == 4)
    for (size_t i = 0; i < image.pixels(); ++i) image.data[4 * i + 3] = i % 2 ? 255 : 0;
  return image;
}

Image8 Mask() {
  Image8 mask(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth / 2; ++x) mask.at(x, y, 0) = 255;
  return mask;
}

struct Imavatar {
  TemporaryFolder folder;
  Json json;

  explicit Imavatar(int count = 10) {
    json = {{"intrinsics", {-2.0, 3.0, 0.5, 0.45}},
            {"shape_params", {0.5, -0.25}},
            {"frames", Json::array()}};
    for (int i = 0; i < count; ++i) {
      const auto [angle, t] = PoseOf(i);
      const double c = std::cos(angle), s = std::sin(angle);
      Json pose = Json::array();
      for (int k = 0; k < 15; ++k) pose.push_back(0.01 * k + 0.1 * i);
      json["frames"].push_back(
          {{"file_path", "./image/" + std::to_string(i + 1)},
           {"world_mat", {{c, 0, s, 4 * t[0]}, {0, 1, 0, 4 * t[1]}, {-s, 0, c, 4 * t[2]}}},
           {"expression", {0.1 * i, 0.2, 0.3}},
           {"pose", pose}});
    }
  }

  void WriteImages(int channels, const std::string& name = "image") const {
    MakeDirectories(folder / name);
    for (size_t i = 1; i <= json["frames"].size(); ++i)
      WriteImage(folder / (name + "/" + std::to_string(i) + ".png"), Image(int(i), channels));
  }

  void WriteMasks() const {
    MakeDirectories(folder / "mask");
    for (size_t i = 1; i <= json["frames"].size(); ++i)
      WriteImage(folder / ("mask/" + std::to_string(i) + ".png"), Mask());
  }

  const std::string& Write() const {
    WriteFileAtomically(folder / "flame_params.json", json.dump());
    return folder.path();
  }
  TrackedVideo Load(const TrackOptions& options = {}) const {
    return LoadTrackedVideo(Write(), options);
  }
};

// The same track in VHAP's layout; frames from `first_test` on are the test split.
struct Vhap {
  TemporaryFolder folder;
  Json train, test;
  std::map<int, Npz> params;

  explicit Vhap(int count = 10, int first_test = 8) {
    train = {{"w", kWidth},
             {"h", kHeight},
             {"fl_x", 2.0 * kWidth},
             {"fl_y", 3.0 * kHeight},
             {"cx", 0.5 * kWidth},
             {"cy", 0.45 * kHeight},
             {"frames", Json::array()}};
    test = train;
    MakeDirectories(folder / "images");
    MakeDirectories(folder / "flame_param");
    for (int i = 0; i < count; ++i) {
      const auto [angle, t] = PoseOf(i);
      const double c = std::cos(angle), s = std::sin(angle);
      // world_from_cam: [R^T, -R^T t].
      const Json matrix = {{c, 0, -s, -(c * t[0] - s * t[2])},
                           {0, 1, 0, -t[1]},
                           {s, 0, c, -(s * t[0] + c * t[2])},
                           {0, 0, 0, 1}};
      const std::string stem = std::to_string(i);
      (i < first_test ? train : test)["frames"].push_back(
          {{"file_path", "images/" + stem + ".png"},
           {"fg_mask_path", "masks/" + stem + ".png"},
           {"flame_param_path", "flame_param/" + stem + ".npz"},
           {"timestep_index", i},
           {"camera_index", 0},
           {"transform_matrix", matrix}});
      WriteImage(folder / ("images/" + stem + ".png"), Image(i + 1, 4));
      FillParams(i);
    }
  }

  void FillParams(int i) {
    const auto vector = [&](int first, int count) {
      std::vector<float> v;
      for (int k = 0; k < count; ++k) v.push_back(float(0.01 * (first + k) + 0.1 * i));
      return v;
    };
    Npz& npz = params[i];
    npz.Add("rotation", {1, 3}, vector(0, 3));
    npz.Add("neck_pose", {1, 3}, vector(3, 3));
    npz.Add("jaw_pose", {1, 3}, vector(6, 3));
    npz.Add("eyes_pose", {1, 6}, vector(9, 6));
    npz.Add("translation", {1, 3}, std::vector<float>{0, 0, 0});
    npz.Add("expr", {1, 3}, std::vector<float>{float(0.1 * i), 0.2f, 0.3f});
    npz.Add("shape", {2}, std::vector<float>{0.5f, -0.25f});
    npz.Add("static_offset", {1, 5143, 3}, std::vector<float>(5143 * 3, 0.f));
  }

  const std::string& Write() const {
    WriteFileAtomically(folder / "transforms_train.json", train.dump());
    WriteFileAtomically(folder / "transforms_test.json", test.dump());
    for (const auto& [i, npz] : params)
      npz.Write(folder / ("flame_param/" + std::to_string(i) + ".npz"));
    return folder.path();
  }
  TrackedVideo Load(const TrackOptions& options = {}) const {
    return LoadTrackedVideo(Write(), options);
  }
};

std::vector<TrackedFrame> AllFrames(const TrackedVideo& video) {
  std::vector<TrackedFrame> all = video.train;
  all.insert(all.end(), video.test.begin(), video.test.end());
  return all;
}

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
  for (int i = 1; i <= 4; ++i) writer.Write(Image(4 * i, 3));
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

TEST(TrackedVideo, VhapTimeIsInTheNamesWhereNothingElseSaysIt) {
  Vhap set(12, 12);
  for (Json& frame : set.train["frames"]) frame.erase("timestep_index");
  std::swap(set.train["frames"][2], set.train["frames"][10]);
  const TrackedVideo video = set.Load({.test_frames = 2});
  ASSERT_EQ(video.test.size(), 2u);
  EXPECT_EQ(video.test[0].name, "10");
  EXPECT_EQ(video.train[2].name, "2");
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

TEST(TrackedVideo, VhapParameterFiles) {
  Vhap set;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  set.params[1].Add("jaw_pose", {1, 3}, std::vector<float>{0, nan, 0});
  set.params[2].Add("eyes_pose", {1, 3}, std::vector<float>{0, 0, 0});
  set.params[3].Add("dynamic_offset", {1, 2, 3}, std::vector<float>{0, 0, 1, 0, 0, 0});
  set.params[8].Add("dynamic_offset", {1, 2, 3}, std::vector<float>(6, 0.f));  // harmless
  const TrackedVideo video = set.Load();
  ASSERT_EQ(video.skipped.size(), 3u);
  EXPECT_NE(video.skipped[0].reason.find("jaw_pose[1] is not finite"), std::string::npos);
  EXPECT_NE(video.skipped[1].reason.find("eyes_pose has 3 numbers, expected 6"), std::string::npos);
  EXPECT_NE(video.skipped[2].reason.find("dynamic_offset"), std::string::npos);
  std::filesystem::remove(set.folder / "flame_param/4.npz");
  set.params.erase(4);
  ExpectError([&] { set.Load(); }, {"4 of 10", "jaw_pose"});
  Vhap cut;
  cut.Load();
  const std::vector<char> bytes = ReadFile(cut.folder / "flame_param/5.npz");
  cut.params.erase(5);
  WriteFileAtomically(cut.folder / "flame_param/5.npz",
                      std::string(bytes.begin(), bytes.end() - 9));
  const TrackedVideo rest = cut.Load();
  ASSERT_EQ(rest.skipped.size(), 1u);
  EXPECT_NE(rest.skipped[0].reason.find("5.npz"), std::string::npos);
}

TEST(TrackedVideo, VhapSubject) {
  Vhap set;
  EXPECT_TRUE(set.Load().static_offset.empty());  // all zero
  Npz canonical;
  std::vector<float> offsets(5143 * 3, 0.f);
  offsets[3] = 0.01f;
  offsets[5142 * 3] = 7;  // of its own teeth
  canonical.Add("shape", {3}, std::vector<float>{1, 2, 3});
  canonical.Add("static_offset", {1, 5143, 3}, offsets);
  canonical.Write(set.folder / "canonical_flame_param.npz");
  const TrackedVideo video = set.Load();
  EXPECT_EQ(video.shape, (std::vector<float>{1, 2, 3}));
  ASSERT_EQ(video.static_offset.size(), 5143u * 3);  // as it is: see StaticOffsetFor
  EXPECT_FLOAT_EQ(video.static_offset[3], 0.01f);
  canonical.Add("static_offset", {1, 3, 5143}, offsets);
  canonical.Write(set.folder / "canonical_flame_param.npz");
  ExpectError([&] { set.Load(); }, {"canonical_flame_param.npz", "static_offset", "[V, 3]"});
  canonical.Add("static_offset", {1, 5143, 3}, offsets);
  canonical.Add("shape", {1}, std::vector<float>{std::numeric_limits<float>::infinity()});
  canonical.Write(set.folder / "canonical_flame_param.npz");
  ExpectError([&] { set.Load(); }, {"canonical_flame_param.npz", "shape[0]", "not finite"});
}

TEST(TrackedVideo, VhapJsonErrorsNameTheField) {
  const struct {
    const char* pointer;
    Json value;
    std::vector<std::string> parts;
  } cases[] = {
      {"/w", 0, {"transforms_train.json", "frames[0]", "not positive"}},
      {"/fl_x", "x", {"transforms_train.json", "fl_x", "\"x\""}},
      {"/frames/2/transform_matrix", 3, {"frames[2].transform_matrix", "an array"}},
      {"/frames/2/flame_param_path", 3, {"flame_param_path", "a string"}},
      {"/frames", Json::object(), {"frames", "an array"}},
      {"/frames/2/timestep_index", 0.033, {"frames[2].timestep_index", "an integer"}},
      {"/frames/2/timestep_index", 1, {"timestep_index", "is 1 for both 1 and 2"}},
      {"/k1", 0.1, {"k1", "undistort"}},
      {"/frames/2/p2", 0.1, {"frames[2].p2", "undistort"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.pointer);
    Vhap set;
    for (int i = 0; i < 8; ++i)  // of a camera that stands still
      set.train["frames"][i]["transform_matrix"] = set.train["frames"][0]["transform_matrix"];
    set.train[Json::json_pointer(c.pointer)] = c.value;
    ExpectError([&] { set.Load(); }, c.parts);
  }
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

TEST(TrackedVideo, NothingThereIsAnError) {
  const TemporaryFolder folder;
  ExpectError([&] { LoadTrackedVideo(folder / "none", {}); }, {"none", "does not exist"});
  ExpectError([&] { LoadTrackedVideo(folder.path(), {}); }, {"flame_params.json", "VHAP"});
  const Imavatar set;
  ExpectError([&] { set.Load({.resolution = 0}); }, {"resolution", "0"});
}

}  // namespace
}  // namespace cosplat

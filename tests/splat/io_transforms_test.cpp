#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "splat/base/files.h"
#include "splat/io/dataset.h"
#include "splat/io/ply.h"
#include "tests/splat/scene_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: the fixture's small vocabulary
using Json = nlohmann::json;

// world_from_cam with OpenGL's axes of the fixture's pose.
Json MatrixOf(const Pose& pose) {
  const Camera camera = WithPose(Camera(), pose);
  const std::array<float, 3> center = camera.Center();
  Json matrix = Json::array();
  for (int r = 0; r < 3; ++r) {
    const auto column = [&](int c) { return double(camera.rotation[3 * c + r]); };
    matrix.push_back({column(0), -column(1), -column(2), center[r]});
  }
  matrix.push_back({0, 0, 0, 1});
  return matrix;
}

Camera FixtureCamera(int index) {
  Camera camera;
  camera.width = kFixtureWidth;
  camera.height = kFixtureHeight;
  camera.fx = 150;
  camera.fy = 140;
  camera.cx = 82;
  camera.cy = 59;
  return WithPose(camera, PoseOf(index % 3));
}

void ExpectSpots(const std::vector<SceneView>& views, double tolerance) {
  for (const SceneView& view : views) {
    const Point2 expected = SpotIn(view.camera), found = Centroid(LoadViewImage(view));
    EXPECT_NEAR(found[0], expected[0], tolerance) << view.name;
    EXPECT_NEAR(found[1], expected[1], tolerance) << view.name;
  }
}

// A nerfstudio scene with images in images/.
struct Nerfstudio {
  TemporaryFolder folder;
  Json json = {{"fl_x", 150}, {"fl_y", 140}, {"cx", 82}, {"cy", 59}, {"w", 160.0}, {"h", 120.0}};

  explicit Nerfstudio(int count = 4, const Lens& lens = nullptr) {
    MakeDirectories(folder / "images");
    json["frames"] = Json::array();
    for (int i = count - 1; i >= 0; --i) {
      const std::string name = "images/" + std::to_string(i) + ".png";
      const Camera camera = FixtureCamera(i);
      Point2 spot = SpotIn(camera);
      if (lens) {
        const Point2 d = lens((spot[0] - 82) / 150, (spot[1] - 59) / 140);
        spot = {150 * d[0] + 82, 140 * d[1] + 59};
      }
      WriteImage(folder / name, SpotImage(camera.width, camera.height, spot));
      json["frames"].push_back(
          {{"file_path", "./" + name}, {"transform_matrix", MatrixOf(PoseOf(i % 3))}});
    }
  }

  SceneData Load(const SceneOptions& options = {}) const {
    WriteFileAtomically(folder / "transforms.json", json.dump());
    return LoadScene(folder.path(), options);
  }
};

TEST(Nerfstudio, CamerasSeeTheSpotWhereItIs) {
  const Nerfstudio scene;
  const SceneData data = scene.Load();
  EXPECT_EQ(data.layout, "nerfstudio");
  ASSERT_EQ(data.train.size(), 4u);
  EXPECT_EQ(data.train[0].name, "images/0.png");
  EXPECT_FLOAT_EQ(data.train[0].camera.fy, 140);
  ExpectSpots(data.train, 0.05);
  ExpectSpots(scene.Load({.resolution = 2}).train, 0.05);
  const SceneData eval = scene.Load({.eval = true});
  EXPECT_EQ(eval.test.size(), 1u);
  EXPECT_EQ(eval.test[0].name, "images/0.png");
}

TEST(Nerfstudio, DistortionIsRemoved) {
  const auto brown = [](double x, double y) {
    const double r2 = x * x + y * y, s = 1 + .1 * r2 - .05 * r2 * r2 + .02 * r2 * r2 * r2;
    return Point2{x * s + 2 * .01 * x * y - .02 * (r2 + 2 * x * x),
                  y * s + .01 * (r2 + 2 * y * y) - 2 * .02 * x * y};
  };
  Nerfstudio scene(3, brown);
  scene.json.update({{"k1", .1}, {"k2", -.05}, {"k3", .02}, {"p1", .01}, {"p2", -.02}});
  ExpectSpots(scene.Load().train, 0.1);
  const auto fisheye = [](double x, double y) {
    const double r = std::hypot(x, y), t = std::atan(r), s = t * (1 + .05 * t * t) / r;
    return Point2{x * s, y * s};
  };
  Nerfstudio round(3, fisheye);
  round.json.update({{"k1", .05}, {"camera_model", "OPENCV_FISHEYE"}});
  ExpectSpots(round.Load().train, 0.1);
  round.json.erase("camera_model");
  round.json["is_fisheye"] = true;
  ExpectSpots(round.Load().train, 0.1);
}

// k1, k2, k3, k4, p1, p2.
TEST(Nerfstudio, DistortionAsAList) {
  Nerfstudio scene;
  scene.json["distortion_params"] = {0.1, -0.05, 0.01, 0, 0.002, -0.003};
  const Distortion listed = scene.Load().train[0].distortion;
  scene.json.erase("distortion_params");
  scene.json.update({{"k1", 0.1}, {"k2", -0.05}, {"k3", 0.01}, {"p1", 0.002}, {"p2", -0.003}});
  const Distortion named = scene.Load().train[0].distortion;
  EXPECT_EQ(listed.model, named.model);
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(listed.k[i], named.k[i], 1e-8);
}

TEST(Nerfstudio, IntrinsicsPerFrameOverrideTheFile) {
  Nerfstudio scene;
  scene.json["fl_x"] = 1;
  for (Json& frame : scene.json["frames"]) frame["fl_x"] = 150;
  ExpectSpots(scene.Load().train, 0.05);
}

TEST(Nerfstudio, AnglesServeAsFocalLengths) {
  Nerfstudio scene;
  scene.json.erase("fl_x");
  scene.json.erase("fl_y");
  scene.json["camera_angle_x"] = 2 * std::atan(80 / 150.0);
  scene.json["camera_angle_y"] = 2 * std::atan(60 / 140.0);
  ExpectSpots(scene.Load().train, 0.05);
  scene.json["camera_angle_x"] = 3.2;
  ExpectError([&] { scene.Load(); }, {"transforms.json", "camera_angle_x", "3.2"});
  scene.json.erase("camera_angle_x");
  EXPECT_FLOAT_EQ(scene.Load().train[0].camera.fx, 140);  // of square pixels
  scene.json.erase("camera_angle_y");
  ExpectError([&] { scene.Load(); }, {"transforms.json", "camera_angle_x", "missing"});
}

TEST(Nerfstudio, ReducedFoldersAndMissingSizes) {
  Nerfstudio scene;
  MakeDirectories(scene.folder / "images_2");
  for (int i = 0; i < 4; ++i) {
    const std::string name = std::to_string(i) + ".png";
    const Image8 full = ReadImage(scene.folder / ("images/" + name));
    WriteImage(scene.folder / ("images_2/" + name), ResizeByArea(full, 80, 60));
  }
  const auto check = [&] {
    const SceneData data = scene.Load({.resolution = 2});
    EXPECT_NE(data.train[0].image_path.find("images_2"), std::string::npos);
    EXPECT_FLOAT_EQ(data.train[0].camera.fx, 75);
    ExpectSpots(data.train, 0.05);
  };
  check();
  scene.json.erase("w");
  scene.json.erase("h");
  check();
}

TEST(Nerfstudio, MasksAreToIgnore) {
  Nerfstudio scene(3);
  Image8 mask(160, 120, 1);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 80; ++x) mask.at(x, y, 0) = 255;
  WriteImage(scene.folder / "mask.png", mask);
  for (Json& frame : scene.json["frames"]) frame["mask_path"] = "mask.png";
  const SceneData data = scene.Load({.resolution = 4});
  EXPECT_EQ(LoadViewImage(data.train[0]).channels, 3);
  const Image8 ignored = LoadIgnored(data.train[0]);
  ASSERT_EQ(ignored.width, 40);
  ASSERT_EQ(ignored.channels, 1);
  EXPECT_EQ(ignored.at(5, 10, 0), 0);
  EXPECT_EQ(ignored.at(30, 10, 0), 255);
  WriteImage(scene.folder / "mask.png", Image8(160, 100, 1));
  ExpectError([&] { LoadIgnored(data.train[0]); }, {"mask.png", "160x100", "160x120"});
  scene.json["frames"][0]["mask_path"] = "none.png";
  const SceneData less = scene.Load();
  ASSERT_EQ(less.skipped.size(), 1u);
  EXPECT_NE(less.skipped[0].reason.find("none.png is missing"), std::string::npos);
}

TEST(Nerfstudio, PointsAreReadWhereNamed) {
  Nerfstudio scene(3);
  EXPECT_TRUE(scene.Load().points.empty());
  WritePointsPly(scene.folder / "p.ply", {1, 2, 3}, {4, 5, 6});
  scene.json["ply_file_path"] = "p.ply";
  const SceneData data = scene.Load();
  EXPECT_EQ(data.points, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(data.point_colors, (std::vector<uint8_t>{4, 5, 6}));
}

TEST(Nerfstudio, BadFramesAreSkippedUpToAThird) {
  Nerfstudio scene(6);
  std::filesystem::remove(scene.folder / "images/3.png");
  scene.json["frames"][0]["transform_matrix"][1][3] = nullptr;  // what NaN becomes
  const SceneData data = scene.Load();
  EXPECT_EQ(data.train.size(), 4u);
  ASSERT_EQ(data.skipped.size(), 2u);
  EXPECT_EQ(data.skipped[0].name, "images/5.png");
  EXPECT_NE(data.skipped[1].reason.find("3.png is missing"), std::string::npos);
  scene.json["frames"][1]["transform_matrix"][0][0] = 7;
  ExpectError([&] { scene.Load(); }, {"3 of 6", "images/5.png"});
}

TEST(Nerfstudio, BadJsonNamesTheField) {
  const struct {
    const char* pointer;
    Json value;
    std::vector<std::string> parts;
  } cases[] = {
      {"/fl_x", "wide", {"transforms.json", "fl_x", "\"wide\"", "finite number"}},
      {"/fl_x", -1, {"fl_x", "not positive"}},
      {"/w", 0, {"w", "not positive"}},
      {"/w", 100.5, {"w", "100.5", "an integer"}},
      {"/h", 100, {"0.png", "160x120", "160x100"}},
      {"/k4", 0.5, {"k4", "beyond k3"}},
      {"/k6", 0.5, {"k6", "beyond k3"}},
      {"/distortion_params", {0, 0, 0, 0.5, 0, 0}, {"distortion_params", "k4", "beyond k3"}},
      {"/camera_model", "EQUIRECTANGULAR", {"camera_model", "EQUIRECTANGULAR"}},
      {"/is_fisheye", 1, {"is_fisheye", "true or false"}},
      {"/ply_file_path", "none.ply", {"none.ply", "No such file"}},
      {"/frames", Json::array(), {"contains no frames"}},
      {"/frames", 3, {"frames", "an array"}},
      {"/frames/0", Json::object(), {"frames[0].file_path", "missing"}},
      {"/frames/0/file_path", 5, {"frames[0].file_path", "5", "a string"}},
      {"/frames/0/transform_matrix", Json::array({1, 2}), {"frames[0]", "2 numbers", "4x4"}},
      {"/frames/0/transform_matrix/1", "x", {"frames[0].transform_matrix[1]", "\"x\""}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.pointer);
    Nerfstudio scene(1);
    scene.json[Json::json_pointer(c.pointer)] = c.value;
    ExpectError([&] { scene.Load(); }, c.parts);
  }
}

// Blender's files: no extension, own split, RGBA, one angle.
struct Blender {
  TemporaryFolder folder;
  Blender() {
    for (const char* split : {"train", "test"}) {
      MakeDirectories(folder / split);
      Json json = {{"camera_angle_x", 2 * std::atan(80 / 150.0)}, {"frames", Json::array()}};
      const int count = split == std::string("train") ? 3 : 2;
      for (int i = 0; i < count; ++i) {
        const std::string name = std::string(split) + "/r_" + std::to_string(i);
        Camera camera = FixtureCamera(i);
        camera.fy = camera.fx;
        camera.cx = 80;
        camera.cy = 60;
        const Image8 rgb = SpotImage(160, 120, SpotIn(camera));
        Image8 rgba(160, 120, 4, 255);
        for (size_t p = 0; p < rgb.pixels(); ++p)
          for (int c = 0; c < 3; ++c) rgba.data[4 * p + c] = rgb.data[3 * p + c];
        WriteImage(folder / (name + ".png"), rgba);
        json["frames"].push_back(
            {{"file_path", "./" + name}, {"transform_matrix", MatrixOf(PoseOf(i))}});
      }
      WriteFileAtomically(folder / ("transforms_" + std::string(split) + ".json"), json.dump());
    }
  }
};

TEST(BlenderScene, KeepsItsOwnSplit) {
  const Blender blender;
  const SceneData data = LoadScene(blender.folder.path(), {.eval = true});
  EXPECT_EQ(data.layout, "blender");
  EXPECT_EQ(data.train.size(), 3u);
  EXPECT_EQ(data.test.size(), 2u);
  EXPECT_TRUE(data.renderings);
  EXPECT_TRUE(data.points.empty());
  EXPECT_EQ(LoadViewImage(data.test[0]).channels, 4);
  ExpectSpots(data.train, 0.05);
  ExpectSpots(data.test, 0.05);
  const SceneData all = LoadScene(blender.folder.path(), {});
  EXPECT_EQ(all.train.size(), 5u);  // without --eval every view trains
  EXPECT_TRUE(all.test.empty());
  const SceneData fold = LoadScene(blender.folder.path(), {.fold = true});
  ASSERT_EQ(fold.test.size(), 1u);
  EXPECT_EQ(fold.test[0].name, "train/r_0.png");
  std::filesystem::remove(blender.folder / "transforms_test.json");
  EXPECT_TRUE(LoadScene(blender.folder.path(), {}).test.empty());
}

TEST(BlenderScene, PointsAreReadWhereNamed) {
  const Blender blender;
  const std::string path = blender.folder / "transforms_train.json";
  WritePointsPly(blender.folder / "p.ply", {1, 2, 3}, {4, 5, 6});
  Json json = Json::parse(ReadFile(path));
  json["ply_file_path"] = "p.ply";
  WriteFileAtomically(path, json.dump());
  EXPECT_EQ(LoadScene(blender.folder.path(), {}).points, (std::vector<float>{1, 2, 3}));
}

}  // namespace
}  // namespace cosplat

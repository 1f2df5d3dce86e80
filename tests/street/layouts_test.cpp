// Data sets as they come: names of another machine, other endings, other programs' fields.
#include <gtest/gtest.h>

#include <filesystem>

#include "splat/base/data_files.h"
#include "splat/media/image_io.h"
#include "tests/street/nerf_scene.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

// Of matching images: the plane is sampled at pixels' centres, so that only rounding is left.
constexpr double kAlike = 1;
constexpr double kOther = 20;  // of images that are not what their cameras see: 30 and more

TEST(DataFiles, AreFoundUnderOtherNames) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "images");
  for (const char* name : {"images/r_0.jpg", "images/One.JPEG", "images/frame.0007.webp", "x.PNG"})
    std::ofstream(folder / name) << "x";
  DataFiles files(folder.path());
  const auto found = [&](const std::string& name) {
    const std::string path = files.FindImage(name);
    return path.empty() ? path : fs::path(path).lexically_relative(folder.path()).string();
  };
  EXPECT_EQ(found("images/r_0"), "images/r_0.jpg");
  EXPECT_EQ(found("./images/r_0.png"), "images/r_0.jpg");
  EXPECT_EQ(found("images/one.jpg"), "images/One.JPEG");
  EXPECT_EQ(found("images/frame.0007"), "images/frame.0007.webp");
  EXPECT_EQ(found("x.png"), "x.PNG");
  EXPECT_EQ(found("D:\\data\\lego\\images\\r_0.jpg"), "images/r_0.jpg");
  EXPECT_EQ(found("images\\r_0.jpg"), "images/r_0.jpg");
  EXPECT_EQ(found("/home/ann/lego/images/r_0.jpg"), "images/r_0.jpg");
  EXPECT_EQ(found("../lego/images/r_0.jpg"), "images/r_0.jpg");
  EXPECT_EQ(found("images/r_1.jpg"), "");
  EXPECT_EQ(StemOf("D:\\a b\\frame.0007.PNG"), "frame.0007");
  EXPECT_EQ(StemOf("images/frame.0007"), "frame.0007");
}

TEST(Layouts, NamesOfAnotherMachine) {
  NerfScene scene;
  for (auto& frame : scene.json["frames"])
    frame["file_path"] = "D:\\captures\\desk\\" + frame["file_path"].get<std::string>();
  const SceneData data = scene.Load();
  EXPECT_TRUE(data.skipped.empty());
  EXPECT_LT(PlaneDifference(data.train), kAlike);
}

TEST(Layouts, NamesThatLeadToOneFile) {
  NerfScene scene;
  WriteImage(scene.folder / "0.png", NerfScene::Photograph(0, 0));
  for (int i = 0; i < 9; ++i)
    scene.json["frames"][i]["file_path"] = "cam" + std::to_string(i) + "/0.png";
  ExpectError([&] { scene.Load(); }, {"cam1/0.png", "cam0/0.png"});
}

TEST(Layouts, ImagesOfAnotherMachineAreReducedOnce) {
  NerfScene scene;
  for (int i = 0; i < 9; ++i) {
    const std::string name = std::to_string(i) + ".png";
    std::filesystem::rename(scene.folder / ("images/" + name), scene.folder / name);
    scene.json["frames"][i]["file_path"] = "D:\\lego\\" + name;
  }
  const SceneData data = scene.Load({.resolution = 2});
  EXPECT_EQ(LoadViewImage(data.train[0]).width, NerfScene::kWidth / 2);
}

TEST(Layouts, MatricesInTheOrderOfColumns) {
  NerfScene scene;
  for (auto& frame : scene.json["frames"]) {
    Json turned = frame["transform_matrix"];
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) turned[c][r] = frame["transform_matrix"][r][c];
    frame["transform_matrix"] = turned;
  }
  const SceneData data = scene.Load();
  EXPECT_LT(PlaneDifference(data.train), kAlike);
  EXPECT_TRUE(Notes(data.notes, "order of columns"));
  for (auto& frame : scene.json["frames"]) frame["transform_matrix"][3][3] = 2;
  ExpectError([&] { scene.Load(); }, {"last row", "expected 0 0 0 1"});
}

TEST(Layouts, AFramesOwnFocalLengthCounts) {
  NerfScene scene;
  scene.json["fl_x"] = 90;
  scene.json["fl_y"] = 90;
  for (auto& frame : scene.json["frames"])
    frame["camera_angle_x"] = 2 * std::atan(NerfScene::kWidth / 2.0 / NerfScene::kFocal);
  EXPECT_LT(PlaneDifference(scene.Load().train), kAlike);
  for (auto& frame : scene.json["frames"]) frame.erase("camera_angle_x");
  EXPECT_GT(PlaneDifference(scene.Load().train), 2 * kAlike);  // that the test can see it
}

TEST(Layouts, TheDatasOwnSplit) {
  NerfScene scene;
  scene.json["test_filenames"] = {scene.Frame(2), scene.Frame(5)};
  scene.json["train_filenames"] = {scene.Frame(0), scene.Frame(1)};
  SceneData data = scene.Load({.eval = true});
  ASSERT_EQ(data.test.size(), 2u);
  EXPECT_EQ(data.test[0].name, "images/2.png");
  EXPECT_EQ(data.train.size(), 2u);
  EXPECT_TRUE(Notes(data.notes, "5 views are in none"));
  EXPECT_EQ(scene.Load().train.size(), 4u);                    // without --eval all that are listed
  scene.json["test_filenames"] = {"/home/ann/desk/images/7"};  // of another machine, no ending
  data = scene.Load({.eval = true});
  ASSERT_EQ(data.test.size(), 1u);
  EXPECT_EQ(data.test[0].name, "images/7.png");
  scene.json["test_filenames"] = {"images/70.png"};
  ExpectError([&] { scene.Load(); }, {"test_filenames", "images/70.png"});
  scene.json.erase("test_filenames");
  data = scene.Load({.eval = true});
  EXPECT_EQ(data.test.size(), 7u);  // those that are not for training
  scene.json.erase("train_filenames");
  scene.json["test_frames"] = Json::array({scene.json["frames"][8]});
  scene.json["frames"].erase(8);
  data = scene.Load({.eval = true});
  EXPECT_EQ(data.test.size(), 1u);
  EXPECT_EQ(data.train.size(), 8u);
}

TEST(Layouts, BlenderWithoutTestViews) {
  const NerfScene scene;
  const SceneData data = scene.Load({.eval = true}, "transforms_train.json");
  EXPECT_EQ(data.test.size(), 2u);
  EXPECT_TRUE(Notes(data.notes, "no transforms_test.json"));
  std::ofstream(scene.folder / "transforms_val.json") << scene.json;
  EXPECT_EQ(scene.Load({.eval = true}, "transforms_train.json").test.size(), 9u);
}

TEST(Layouts, ReducedImagesThatAreNotAllThere) {
  const NerfScene scene;
  fs::create_directories(scene.folder / "images_2");
  for (int i = 0; i < 5; ++i) {
    const std::string name = "/" + std::to_string(i) + ".png";
    const Image8 image = ReadImage(scene.folder / ("images" + name));
    WriteImage(scene.folder / ("images_2" + name), ResizeByArea(image, 32, 24));
  }
  const SceneData data = scene.Load({.resolution = 2});
  ASSERT_EQ(data.train.size(), 9u);
  for (const SceneView& view : data.train) EXPECT_EQ(LoadViewImage(view).width, 32);
  EXPECT_TRUE(Notes(data.notes, "4 images are not in the folder"));
}

TEST(Layouts, PointsBesideTheCameras) {
  for (const char* name : {"points3D.ply", "points3d.ply", "sparse_pc.ply"}) {
    const NerfScene scene;
    scene.WritePoints(name);
    const SceneData data = scene.Load();
    EXPECT_EQ(data.points.size(), 3u * 400) << name;
    EXPECT_TRUE(Notes(data.notes, name));
  }
}

// A COLMAP model of the scene's first `count` views.
void WriteModel(const NerfScene& scene, const std::string& folder, int count) {
  fs::create_directories(folder);
  std::ofstream(folder + "/cameras.txt") << "1 PINHOLE 64 48 60 60 32 24\n";
  std::ofstream images(folder + "/images.txt");
  for (int i = 0; i < count; ++i) {
    const Json& m = scene.json["frames"][i]["transform_matrix"];
    images << i + 1 << " 1 0 0 0 " << -m[0][3].get<double>() << ' ' << -m[1][3].get<double>()
           << " 0 1 " << i << ".png\n\n";
  }
  std::ofstream(folder + "/points3D.txt") << "";
}

TEST(Layouts, TheLargestOfColmapsModels) {
  const NerfScene scene;
  WriteModel(scene, scene.folder / "sparse/0", 3);
  WriteModel(scene, scene.folder / "sparse/1", 8);
  const SceneData data = LoadScene(scene.folder.path(), {});
  EXPECT_EQ(data.train.size(), 8u);
  EXPECT_TRUE(Notes(data.notes, "0 3, 1 8"));
  scene.WritePoints("sparse/0/points3D.ply");  // of the other model
  EXPECT_TRUE(LoadScene(scene.folder.path(), {}).points.empty());
  scene.WritePoints("sparse/1/points3D.ply");
  EXPECT_EQ(LoadScene(scene.folder.path(), {}).points.size(), 3u * 400);
  EXPECT_LT(PlaneDifference(data.train), kAlike);
  fs::create_directories(scene.folder / "colmap");  // as nerfstudio keeps it
  fs::rename(scene.folder / "sparse", scene.folder / "colmap/sparse");
  EXPECT_EQ(LoadScene(scene.folder.path(), {}).train.size(), 8u);
}

// What a phone stores: pixels on their side or upside down, and a tag that says so.
TEST(Layouts, ImagesWithAnOrientation) {
  for (const int orientation : {3, 6, 8}) {
    for (const bool stale : {false, true}) {
      for (const bool points : {false, true}) {
        // Upside down and stale without points: nothing tells, so viewers' way counts.
        if (orientation == 3 && stale && !points) continue;
        const NerfScene scene(9, "images", ".jpg");
        if (points) scene.WritePoints("points3D.ply");
        const int inverse = orientation == 6 ? 8 : orientation == 8 ? 6 : 3;
        for (int i = 0; i < 9; ++i) {
          const std::string path = scene.folder / scene.Frame(i);
          if (!stale) WriteImage(path, Upright(ReadImage(path), inverse));
          SetOrientation(path, orientation);
        }
        const std::string cut = scene.folder / scene.Frame(8);  // cannot be read, and is not asked
        fs::resize_file(cut, fs::file_size(cut) / 2);
        SceneData data = scene.Load();
        ASSERT_EQ(data.train.size(), 9u) << orientation;
        EXPECT_THROW(LoadViewImage(data.train.back()), Error);
        data.train.pop_back();
        EXPECT_LT(PlaneDifference(data.train), kOther / 2)  // JPEG's colours at the edges
            << orientation << (stale ? " stale" : "") << (points ? " with points" : "");
      }
    }
  }
}

}  // namespace
}  // namespace cosplat::test

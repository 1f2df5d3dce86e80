// What scenes of every layout have: masks, extent, pinholes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "splat/base/files.h"
#include "splat/io/dataset.h"
#include "splat/io/view_files.h"
#include "tests/splat/scene_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: the fixture's small vocabulary

// Named with the image's extension, as COLMAP does, or without; at the images' or another size.
TEST(Scene, MasksAreFoundInTheirFolder) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  MakeDirectories(folder / "masks");
  Image8 mask(80, 60, 1, 255);
  for (int y = 0; y < 60; ++y)
    for (int x = 50; x < 80; ++x) mask.at(x, y, 0) = 90;
  WriteImage(folder / "masks/img 0.png.png", mask);
  WriteImage(folder / "masks/img 1.png", mask);
  WriteImage(folder / "masks/img 2.png", Image8(80, 50, 1));
  const SceneData scene = LoadScene(folder.path(), {.resolution = 2});
  for (const size_t view : {0u, 1u}) {
    const Image8 ignored = LoadIgnored(scene.train[view]);
    ASSERT_EQ(ignored.width, 80);
    ASSERT_EQ(ignored.height, 60);
    for (const auto& [x, value] : {std::pair{0, 0}, {49, 0}, {50, 255}, {79, 255}})
      EXPECT_EQ(ignored.at(x, 30, 0), value) << x;
  }
  ExpectError([&] { LoadIgnored(scene.train[2]); }, {"masks/img 2.png", "80x50", "160x120"});
  EXPECT_TRUE(LoadIgnored(scene.train[3]).empty());
}

TEST(Scene, MasksUnderOtherNames) {
  const Image8 mask(160, 120, 1, 255);
  for (const char* name : {"Masks/img 1.jpg", "masks_8/img 1.PNG", "masks/img 1_mask.png"}) {
    const TemporaryFolder folder;
    WriteScene(folder, PinholeFixture());
    MakeDirectories(std::filesystem::path(folder / name).parent_path().string());
    WriteImage(folder / name, mask);
    const SceneData scene = LoadScene(folder.path(), {});
    EXPECT_EQ(scene.train[1].mask_path, folder / name);
    ASSERT_EQ(scene.notes.size(), 1u);
    EXPECT_NE(scene.notes[0].find("1 of 4 views have masks"), std::string::npos) << scene.notes[0];
  }
  for (const char* name : {"mask/img 1.png", "masks/1.png"}) {
    const TemporaryFolder folder;
    WriteScene(folder, PinholeFixture());
    MakeDirectories(std::filesystem::path(folder / name).parent_path().string());
    WriteImage(folder / name, mask);
    const SceneData scene = LoadScene(folder.path(), {});
    ASSERT_EQ(scene.notes.size(), 1u) << name;
    EXPECT_NE(scene.notes[0].find("masks/NAME.png is"), std::string::npos) << scene.notes[0];
  }
}

TEST(Scene, NothingThereIsAnError) {
  const TemporaryFolder folder;
  ExpectError([&] { LoadScene(folder / "none", {}); }, {"none", "is not a folder"});
  ExpectError([&] { LoadScene(folder.path(), {}); }, {folder.path(), "contains no scene"});
  ExpectError([&] { LoadScene(folder.path(), {.resolution = 0}); }, {"resolution", "0"});
  MakeDirectories(folder / "sparse/0");
  ExpectError([&] { LoadScene(folder.path(), {}); }, {"sparse/0", "cameras.bin"});
}

TEST(Scene, ExtentIsThatOf3dgs) {
  std::vector<SceneView> views(3);
  EXPECT_EQ(SceneExtent(views), 1);          // all in one place
  views[0].camera.translation = {-3, 0, 0};  // centres: (3,0,0), the origin, the origin
  EXPECT_NEAR(SceneExtent(views), 1.1 * 2, 1e-6);
}

// All of the replacing pinhole's border lies in the image, and no wider one's does.
TEST(View, PinholeInsideIsTheWidest) {
  Camera lens;
  lens.width = 160;
  lens.height = 120;
  lens.fx = lens.fy = 90;
  lens.cx = 83;
  lens.cy = 58;
  const auto overshoot = [&](const Distortion& distortion, const Camera& pinhole) {
    std::vector<Point2> border;
    for (int i = 0; i <= 400; ++i) {
      const double x = i * 0.4, y = i * 0.3;
      for (const Point2& p : {Point2{x, 0}, Point2{x, 120}, Point2{0, y}, Point2{160, y}})
        border.push_back(p);
    }
    double worst = -1e9;
    for (const auto& [x, y] : DistortedPixels(lens, distortion, pinhole, border))
      worst = std::max({worst, -x, -y, x - 160, y - 120});
    return worst;
  };
  using Model = Distortion::Model;
  for (const Distortion& distortion : {Distortion{Model::kBrown, {-.15, .02}},
                                       Distortion{Model::kBrown, {.2, .05, .01, -.01}},
                                       Distortion{Model::kFisheye, {.01, -.02}}}) {
    const Camera pinhole = PinholeInside("f", lens, distortion);
    EXPECT_NEAR(overshoot(distortion, pinhole), 0, 0.15);
    EXPECT_EQ(pinhole.width, 160);
    EXPECT_FLOAT_EQ(pinhole.cx, 83);
    EXPECT_FLOAT_EQ(pinhole.fx, pinhole.fy);
  }
  const Camera same = PinholeInside("f", lens, Distortion());
  EXPECT_EQ(same.fx, lens.fx);
  // A lens whose polynomial folds back at once shows nothing that a pinhole could.
  const Distortion folds{Model::kBrown, {-5000}};
  ExpectError([&] { PinholeInside("f", lens, folds); }, {"f", "distortion"});
}

}  // namespace
}  // namespace cosplat

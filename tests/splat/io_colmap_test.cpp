#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <sstream>

#include "splat/base/files.h"
#include "splat/io/colmap_model.h"
#include "splat/io/dataset.h"
#include "splat/io/view_files.h"
#include "tests/splat/scene_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: the fixture's small vocabulary

void WriteTextModel(const TemporaryFolder& folder, const ColmapFixture& fixture) {
  MakeDirectories(folder / "sparse");
  std::string cameras = "# comment\n7 " + fixture.model + " 160 120";
  for (double p : fixture.params) cameras.append(" ").append(std::to_string(p));
  std::string images = "# comment\n# another\n";
  for (int i = fixture.images - 1; i >= 0; --i) {
    images += std::to_string(i + 1);
    for (double q : PoseOf(i % 3).quaternion) images.append(" ").append(std::to_string(q));
    for (double t : PoseOf(i % 3).translation) images.append(" ").append(std::to_string(t));
    images += " 7 " + FixtureName(i) + "\r\n" + (i % 2 ? "" : "1.0 2.0 -1") + "\n";
  }
  WriteFileAtomically(folder / "sparse/cameras.txt", cameras + "\n");
  WriteFileAtomically(folder / "sparse/images.txt", images);
  WriteFileAtomically(folder / "sparse/points3D.txt",
                      "# c\n5 0.35 -0.2 0.1 10 20 30 0.5 1 0\n6 1.35 0.8 1.1 10 20 31 0.5\n");
}

void ExpectSpots(const std::vector<SceneView>& views, double tolerance) {
  for (const SceneView& view : views) {
    const Image8 image = LoadViewImage(view);
    ASSERT_EQ(image.width, view.camera.width);
    ASSERT_EQ(image.height, view.camera.height);
    const Point2 expected = SpotIn(view.camera), found = Centroid(image);
    EXPECT_NEAR(found[0], expected[0], tolerance) << view.name;
    EXPECT_NEAR(found[1], expected[1], tolerance) << view.name;
  }
}

TEST(Colmap, ReadsABinaryModel) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  const SceneData scene = LoadScene(folder.path(), {});
  EXPECT_EQ(scene.layout, "colmap");
  ASSERT_EQ(scene.train.size(), 4u);
  EXPECT_TRUE(scene.test.empty());
  EXPECT_EQ(scene.train[0].name, "img 0.png");  // sorted by name
  const Camera expected = WithPose(Camera(), PoseOf(0));
  for (int i = 0; i < 9; ++i)
    EXPECT_NEAR(scene.train[0].camera.rotation[i], expected.rotation[i], 1e-6);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(scene.train[0].camera.translation[i], expected.translation[i], 1e-6);
  EXPECT_EQ(scene.points.size(), 6u);
  EXPECT_FLOAT_EQ(scene.points[4], 0.8f);
  EXPECT_EQ(scene.point_colors, (std::vector<uint8_t>{10, 20, 30, 10, 20, 31}));
  EXPECT_FALSE(scene.renderings);
  ExpectSpots(scene.train, 0.05);
}

// Points of which COLMAP knows no error have -1, and text of other programs may lack it.
TEST(Colmap, TheMeanErrorIsOfThePointsThatHaveOne) {
  const TemporaryFolder binary, text;
  WriteScene(binary, PinholeFixture());
  EXPECT_DOUBLE_EQ(ReadColmapModel(binary / "sparse/0").mean_error, 0.5);
  WriteTextModel(text, PinholeFixture());
  const std::string points = text / "sparse/points3D.txt";
  WriteFileAtomically(points, "5 0 0 0 1 2 3 0.5\n6 0 0 1 1 2 3 -1\n7 0 1 0 1 2 3 1.5 1 0\n");
  EXPECT_DOUBLE_EQ(ReadColmapModel(text / "sparse").mean_error, 1.0);
  WriteFileAtomically(points, "5 0 0 0 1 2 3\n");
  EXPECT_DOUBLE_EQ(ReadColmapModel(text / "sparse").mean_error, 0.0);
}

// With the rigs and frames that COLMAP 3.12 and later write beside them.
TEST(Colmap, TextAndBinaryGiveTheSame) {
  const TemporaryFolder binary, text;
  WriteScene(binary, PinholeFixture());
  WriteTextModel(text, PinholeFixture());
  WriteFileAtomically(binary / "sparse/0/rigs.bin", Bytes().Put<uint64_t>(1).str());
  WriteFileAtomically(binary / "sparse/0/frames.bin", Bytes().Put<uint64_t>(4).str());
  WriteFileAtomically(text / "sparse/rigs.txt", "1 1 CAMERA 7\n");
  WriteFileAtomically(text / "sparse/frames.txt", "1 1 1 0 0 0 0 0 3 1 CAMERA 7 1\n");
  std::filesystem::copy(binary / "images", text / "images");
  const SceneData a = LoadScene(binary.path(), {}), b = LoadScene(text.path(), {});
  ASSERT_EQ(a.train.size(), b.train.size());
  for (size_t i = 0; i < a.train.size(); ++i) {
    EXPECT_EQ(a.train[i].name, b.train[i].name);
    EXPECT_FLOAT_EQ(a.train[i].camera.fx, b.train[i].camera.fx);
    for (int k = 0; k < 9; ++k)
      EXPECT_NEAR(a.train[i].camera.rotation[k], b.train[i].camera.rotation[k], 2e-6);
  }
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.point_colors, b.point_colors);
  EXPECT_NEAR(a.extent, b.extent, 1e-5);
}

// Every model, its formula written out from COLMAP's documentation: the spot must lie where the
// pinhole that replaces the lens sees it.
TEST(Colmap, UndistortsEveryModelThatOpenCvKnows) {
  const auto radial = [](double k1, double k2) {
    return [=](double x, double y) {
      const double r2 = x * x + y * y, s = 1 + k1 * r2 + k2 * r2 * r2;
      return Point2{x * s, y * s};
    };
  };
  const auto tangential = [](double k1, double k2, double p1, double p2, double k3, double d) {
    return [=](double x, double y) {
      const double r2 = x * x + y * y;
      const double s = (1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2) / (1 + d * r2);
      return Point2{x * s + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                    y * s + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
    };
  };
  const auto fisheye = [](double k1, double k2) {
    return [=](double x, double y) {
      const double r = std::hypot(x, y), t = std::atan(r);
      const double s = r > 0 ? t * (1 + k1 * t * t + k2 * t * t * t * t) / r : 1;
      return Point2{x * s, y * s};
    };
  };
  // The distorted point whose ray, d / (1 + k |d|^2), is the given one: found by bisection of |d|.
  const auto division = [](double k) {
    return [=](double x, double y) {
      const double r = std::hypot(x, y);
      double low = 0, high = k > 0 ? 1 / std::sqrt(k) : 100;  // the ray grows up to there
      for (int i = 0; i < 100; ++i) {
        const double d = (low + high) / 2;
        (k * d * d > -1 && d / (1 + k * d * d) < r ? low : high) = d;
      }
      return Point2{x * low / r, y * low / r};
    };
  };
  const std::vector<ColmapFixture> fixtures{
      {0, "SIMPLE_PINHOLE", {150, 80, 60}},
      {1, "PINHOLE", {150, 150, 80, 60}},
      {2, "SIMPLE_RADIAL", {150, 80, 60, -.2}, radial(-.2, 0)},
      {3, "RADIAL", {150, 80, 60, .15, .05}, radial(.15, .05)},
      {4, "OPENCV", {150, 150, 80, 60, -.1, .02, .01, -.02}, tangential(-.1, .02, .01, -.02, 0, 0)},
      {5, "OPENCV_FISHEYE", {150, 150, 80, 60, .05, -.02, 0, 0}, fisheye(.05, -.02)},
      {6,
       "FULL_OPENCV",
       {150, 150, 80, 60, .1, .02, .01, -.02, .03, .05, 0, 0},
       tangential(.1, .02, .01, -.02, .03, .05)},
      {8, "SIMPLE_RADIAL_FISHEYE", {150, 80, 60, .1}, fisheye(.1, 0)},
      {9, "RADIAL_FISHEYE", {150, 80, 60, -.05, .02}, fisheye(-.05, .02)},
      {12, "SIMPLE_DIVISION", {150, 80, 60, -.3}, division(-.3)},
      {12, "SIMPLE_DIVISION", {150, 80, 60, 0}},
      {13, "DIVISION", {150, 140, 75, 62, .2}, division(.2), 150, 140, 75, 62},
      {14, "SIMPLE_FISHEYE", {150, 80, 60}, fisheye(0, 0)},
      {15, "FISHEYE", {150, 140, 75, 62}, fisheye(0, 0), 150, 140, 75, 62}};
  for (const ColmapFixture& fixture : fixtures) {
    SCOPED_TRACE(fixture.model);
    const TemporaryFolder folder;
    WriteScene(folder, fixture);
    ExpectSpots(LoadScene(folder.path(), {}).train, 0.1);
    ExpectSpots(LoadScene(folder.path(), {.resolution = 2}).train, 0.05);
    const TemporaryFolder text;
    WriteTextModel(text, fixture);
    std::filesystem::copy(folder / "images", text / "images");
    ExpectSpots(LoadScene(text.path(), {}).train, 0.1);
  }
}

// There and back: the ray of each distorted point is the one that went in, up to the lens's edge.
TEST(Colmap, TheDivisionModelIsInvertedExactly) {
  for (const double k : {-2.0, -.3, -1e-12, 1e-12, .2, 2.0}) {
    const ColmapCamera camera =
        MakeColmapCamera("f", "c", "DIVISION", {160, 120}, {150, 140, 75, 62, k});
    Camera target = camera.lens;
    std::vector<Point2> points;
    for (int i = 0; i < 16; ++i) points.push_back({75 + 150 * .02 * i, 62 - 140 * .01 * i});
    const auto distorted = DistortedPixels(camera.lens, camera.distortion, target, points);
    for (size_t i = 0; i < points.size(); ++i) {
      const double x = (distorted[i][0] - 75) / 150, y = (distorted[i][1] - 62) / 140;
      const double s = 1 + k * (x * x + y * y);
      EXPECT_NEAR(x / s, .02 * double(i), 1e-9) << k;
      EXPECT_NEAR(y / s, -.01 * double(i), 1e-9) << k;
    }
    // Beyond the edge of a lens with k > 0, at a ray of 1 / (2 sqrt(k)), it shows nothing.
    const auto beyond = DistortedPixels(camera.lens, camera.distortion, target, {{75e9, 62}});
    EXPECT_EQ(std::isfinite(beyond[0][0]), k < 0) << k;
  }
}

TEST(Colmap, RefusesOtherModelsByName) {
  const std::vector<ColmapFixture> fixtures{
      {7, "FOV", {150, 150, 80, 60, .1}},
      {10, "THIN_PRISM_FISHEYE", {150, 150, 80, 60, 0, 0, 0, 0, 0, 0, 0, 0}},
      {11, "RAD_TAN_THIN_PRISM_FISHEYE", {150, 150, 80, 60, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}},
      {16, "EUCM", {150, 150, 80, 60, .5, 1}},
      {17, "EQUIRECTANGULAR", {160, 120}}};
  for (const ColmapFixture& fixture : fixtures) {
    const TemporaryFolder folder, text;
    WriteScene(folder, fixture);
    ExpectError([&] { LoadScene(folder.path(), {}); },
                {"cameras.bin", "camera 1 of 1", fixture.model});
    WriteTextModel(text, fixture);
    ExpectError([&] { LoadScene(text.path(), {}); }, {"cameras.txt", "line 2", fixture.model});
  }
  ColmapFixture unknown = PinholeFixture();
  unknown.model_id = 99;
  const TemporaryFolder folder;
  WriteScene(folder, unknown);
  ExpectError([&] { LoadScene(folder.path(), {}); }, {"cameras.bin", "99"});
}

TEST(Colmap, HoldsOutEvery8thByName) {
  ColmapFixture fixture = PinholeFixture();
  fixture.images = 10;
  const TemporaryFolder folder;
  WriteScene(folder, fixture);
  const SceneData eval = LoadScene(folder.path(), {.eval = true});
  ASSERT_EQ(eval.test.size(), 2u);
  EXPECT_EQ(eval.test[0].name, "img 0.png");
  EXPECT_EQ(eval.test[1].name, "img 8.png");
  EXPECT_EQ(eval.train.size(), 8u);
  // The fold takes every 8th of those eight and never shows the real test set.
  for (bool with_eval : {false, true}) {
    const SceneData fold = LoadScene(folder.path(), {.eval = with_eval, .fold = true});
    ASSERT_EQ(fold.test.size(), 1u);
    EXPECT_EQ(fold.test[0].name, "img 1.png");
    EXPECT_EQ(fold.train.size(), 7u);
  }
}

TEST(Colmap, TakesReducedFoldersWhereTheyAre) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture(), 4);
  const SceneData scene = LoadScene(folder.path(), {.resolution = 4});
  EXPECT_EQ(scene.train[0].camera.width, 40);
  EXPECT_FLOAT_EQ(scene.train[0].camera.fx, 37.5f);
  ExpectSpots(scene.train, 0.05);
  // images_4 serves -r 8, too, but not -r 2 or the full size.
  EXPECT_EQ(LoadScene(folder.path(), {.resolution = 8}).train[0].camera.width, 20);
  ExpectError([&] { LoadScene(folder.path(), {.resolution = 2}); },
              {"no folder images or images_2", "use -r 4"});
  ExpectError([&] { LoadScene(folder.path(), {}); },
              {"no folder images", "found images_4: use -r 4"});
}

TEST(Colmap, SkipsMissingImagesAndBadPoses) {
  ColmapFixture fixture = PinholeFixture();
  fixture.images = 6;
  const TemporaryFolder folder;
  WriteScene(folder, fixture);
  std::filesystem::remove(folder / ("images/" + FixtureName(2)));
  std::string images = ImagesBin(fixture);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(images.data() + 8 + 4 + 8 * 5, &nan, 8);  // first record (img 5), translation y
  WriteFileAtomically(folder / "sparse/0/images.bin", images);
  const SceneData scene = LoadScene(folder.path(), {});
  EXPECT_EQ(scene.train.size(), 4u);
  ASSERT_EQ(scene.skipped.size(), 2u);
  EXPECT_EQ(scene.skipped[0].name, FixtureName(5));
  EXPECT_NE(scene.skipped[0].reason.find("translation that is not finite"), std::string::npos);
  EXPECT_NE(scene.skipped[1].reason.find("img 2.png is missing"), std::string::npos);
  std::filesystem::remove(folder / ("images/" + FixtureName(3)));
  ExpectError([&] { LoadScene(folder.path(), {}); }, {"3 of 6 frames", "img 2.png"});
  const double zero[4] = {0, 0, 0, 0};
  std::memcpy(images.data() + 8 + 4, zero, 32);
  WriteFileAtomically(folder / "sparse/0/images.bin", images);
  ExpectError([&] { LoadScene(folder.path(), {}); }, {"rotation that is not finite"});
}

TEST(Colmap, TruncatedFilesNameFileAndRecord) {
  const struct {
    const char* name;
    std::string bytes;
  } files[] = {{"cameras.bin", CamerasBin(PinholeFixture())},
               {"images.bin", ImagesBin(PinholeFixture())},
               {"points3D.bin", PointsBin()}};
  for (const auto& file : files) {
    const TemporaryFolder folder;
    WriteScene(folder, PinholeFixture());
    const std::string path = folder / ("sparse/0/" + std::string(file.name));
    for (size_t cut = 0; cut < file.bytes.size(); ++cut) {
      WriteFileAtomically(path, file.bytes.substr(0, cut));
      ExpectError([&] { LoadScene(folder.path(), {}); },
                  {file.name, cut < 8 ? "header" : " of ", "ends at byte " + std::to_string(cut)});
    }
    WriteFileAtomically(path, file.bytes + "x");
    ExpectError([&] { LoadScene(folder.path(), {}); }, {file.name, "1 bytes follow"});
  }
}

TEST(Colmap, HostileCountsEndInAnError) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string path = folder / ("sparse/0/" + std::string(name));
    const std::vector<char> old = ReadFile(path);
    WriteFileAtomically(path, Bytes().Put(~uint64_t(0)).str());
    ExpectError([&] { LoadScene(folder.path(), {}); }, {name});
    WriteFileAtomically(path, std::string(old.begin(), old.end()));
  }
}

TEST(Colmap, BadTextNamesTheLine) {
  const struct {
    const char *file, *text;
    std::vector<std::string> parts;
  } cases[] = {
      {"cameras.txt", "7 PINHOLE 160 x 150 150 80 60", {"line 1", "'x'", "an image height"}},
      {"cameras.txt", "7 PINHOLE 160", {"line 1", "the line ends", "an image height"}},
      {"cameras.txt", "7 PINHOLE 160 120 150 150 80", {"line 1", "3 parameters, expected 4"}},
      {"cameras.txt", "7 PINHOLE 160 120 nan 150 80 60", {"not finite"}},
      {"cameras.txt", "7 PINHOLE 160 120 -5 150 80 60", {"-5", "not positive"}},
      {"cameras.txt", "7 PINHOLE 0 120 150 150 80 60", {"0x120"}},
      {"cameras.txt", "", {"images.txt", "camera 7", "does not exist"}},
      {"images.txt", "1 1 0 0 0 0 0 3 7\n", {"line 1", "an image name"}},
      {"images.txt", "1 1 0 0 zero 0 0 3 7 a.png\n", {"line 1", "'zero'", "a rotation"}},
      {"images.txt", "# nothing\n", {"images.txt", "contains no images"}},
      {"points3D.txt", "5 0 0 0 10 20 300 0\n", {"line 1", "300"}},
      {"points3D.txt", "5 0 nan 0 10 20 30 0\n", {"record 0", "not finite"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.text);
    const TemporaryFolder folder;
    WriteTextModel(folder, PinholeFixture());
    WriteFileAtomically(folder / ("sparse/" + std::string(c.file)), c.text);
    ExpectError([&] { LoadScene(folder.path(), {}); }, c.parts);
  }
}

TEST(Colmap, ImageThatCannotBeUsedIsSkipped) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  WriteImage(folder / "images/img 1.png", Image8(160, 117, 3));
  const auto expect_skipped = [&](const std::vector<std::string>& parts) {
    const SceneData scene = LoadScene(folder.path(), {});
    ASSERT_EQ(scene.skipped.size(), 1u);
    for (const std::string& part : parts)
      EXPECT_NE(scene.skipped[0].reason.find(part), std::string::npos) << scene.skipped[0].reason;
  };
  expect_skipped({"img 1.png", "160x117", "160x120"});
  // A pixel of rounding is not a disagreement, and cameras of half-size images are scaled.
  WriteImage(folder / "images/img 1.png", Image8(80, 61, 3));
  const SceneData scene = LoadScene(folder.path(), {});
  EXPECT_FLOAT_EQ(scene.train[1].camera.fx, 75);
  EXPECT_FLOAT_EQ(scene.train[1].camera.cy, 30.5f);
  WriteFileAtomically(folder / "images/img 1.png", "broken");
  expect_skipped({"img 1.png", "cannot be decoded"});
}

TEST(Colmap, FilesThatChangeAfterLoadingAreErrors) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  const SceneData scene = LoadScene(folder.path(), {});
  WriteImage(scene.train[0].image_path, Image8(80, 60, 3));
  ExpectError([&] { LoadViewImage(scene.train[0]); }, {"img 0.png", "80x60", "160x120"});
}

// Some programs leave out the line of observations; editors put a mark before the first.
TEST(Colmap, TextAsProgramsWriteIt) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  std::filesystem::remove_all(folder / "sparse/0");
  WriteTextModel(folder, PinholeFixture());
  const size_t views = LoadScene(folder.path(), {}).train.size();
  const std::vector<char> bytes = ReadFile(folder / "sparse/images.txt");
  std::istringstream lines(std::string(bytes.begin(), bytes.end()));
  std::string text = "\xEF\xBB\xBF# Number of images: 50, mean observations per image: 0\n";
  for (std::string line; std::getline(lines, line);)
    if (line.find(".png") != std::string::npos) text += line + "\n";
  WriteFileAtomically(folder / "sparse/images.txt", text);
  const SceneData scene = LoadScene(folder.path(), {});
  EXPECT_EQ(scene.train.size(), views);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_NE(scene.notes[0].find("says that it has 50 images, and has 4"), std::string::npos)
      << scene.notes[0];
}

TEST(Colmap, ImagesWithoutACameraAreNoted) {
  const TemporaryFolder folder;
  WriteScene(folder, PinholeFixture());
  WriteImage(folder / "images/other.jpg", Image8(160, 120, 3));
  const SceneData scene = LoadScene(folder.path(), {});
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_NE(scene.notes[0].find("1 of 5 images have no camera"), std::string::npos)
      << scene.notes[0];
}

}  // namespace
}  // namespace cosplat

// The loaders on the real data sets, where they are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splat/io/dataset.h"
#include "tests/splat/scene_fixture.h"

namespace cosplat {
namespace {

std::string DataFolder(const std::string& name) {
  return COSPLAT_SOURCE_DIR "/../shared/data/" + name;
}

// Median difference between the colour that COLMAP gave a point (the mean over the images that
// observe it) and the pixel where `camera` sees it, over points in view; nothing hides points here,
// so it is a median.
double MedianColorDifference(const SceneData& scene, const Camera& camera, const Image8& image) {
  std::vector<double> differences;
  for (size_t i = 0; i < scene.points.size() / 3; ++i) {
    const float* p = &scene.points[3 * i];
    const test::Point3 q = test::ToCamera(camera, {p[0], p[1], p[2]});
    if (q[2] <= 0) continue;
    const double x = camera.fx * q[0] / q[2] + camera.cx;
    const double y = camera.fy * q[1] / q[2] + camera.cy;
    if (!(x >= 0 && y >= 0 && x < camera.width && y < camera.height)) continue;
    double difference = 0;
    for (int c = 0; c < 3; ++c)
      difference += std::abs(image.at(int(x), int(y), c) - scene.point_colors[3 * i + c]) / 3.0;
    differences.push_back(difference);
  }
  if (differences.size() < 500) return 255;
  const auto middle = differences.begin() + long(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
}

void ExpectPointsOnTheirPixels(const SceneData& scene) {
  for (size_t i = 0; i < scene.train.size(); i += 20) {
    const SceneView& view = scene.train[i];
    const Image8 image = LoadViewImage(view);
    const double right = MedianColorDifference(scene, view.camera, image);
    Camera mirrored = view.camera;  // what a wrong sign of y would give
    for (int k = 3; k < 6; ++k) mirrored.rotation[k] *= -1;
    mirrored.translation[1] *= -1;
    const double wrong = MedianColorDifference(scene, mirrored, image);
    EXPECT_LT(right, 0.6 * wrong) << view.name;
  }
}

TEST(RealScenes, Fox) {
  if (!std::filesystem::exists(DataFolder("fox"))) GTEST_SKIP() << "fox is not here";
  const SceneData scene = LoadScene(DataFolder("fox"), {.resolution = 4, .eval = true});
  EXPECT_EQ(scene.train.size(), 43u);
  EXPECT_EQ(scene.test.size(), 7u);
  EXPECT_EQ(scene.points.size(), 3u * 12799);
  EXPECT_EQ(scene.train[0].camera.width, 265);
  ExpectPointsOnTheirPixels(scene);
}

TEST(RealScenes, Garden) {
  if (!std::filesystem::exists(DataFolder("garden"))) GTEST_SKIP() << "garden is not here";
  const SceneData scene = LoadScene(DataFolder("garden"), {.resolution = 8, .eval = true});
  EXPECT_EQ(scene.train.size(), 161u);
  EXPECT_EQ(scene.test.size(), 24u);
  EXPECT_EQ(scene.points.size(), 3u * 138766);
  EXPECT_EQ(scene.train[0].camera.width, 648);
  ExpectPointsOnTheirPixels(scene);
}

TEST(RealScenes, FoxRaw) {
  if (!std::filesystem::exists(DataFolder("fox_raw"))) GTEST_SKIP() << "fox_raw is not here";
  const SceneData scene = LoadScene(DataFolder("fox_raw"), {.resolution = 8, .eval = true});
  EXPECT_EQ(scene.train.size(), 43u);
  EXPECT_EQ(scene.test.size(), 7u);
  EXPECT_EQ(scene.skipped.size(), 17u);
  EXPECT_EQ(scene.train[0].camera.width, 135);
  EXPECT_EQ(LoadViewImage(scene.train[0]).height, 240);
}

TEST(RealScenes, Chair) {
  if (!std::filesystem::exists(DataFolder("chair"))) GTEST_SKIP() << "chair is not here";
  const SceneData scene = LoadScene(DataFolder("chair"), {.resolution = 4, .eval = true});
  EXPECT_EQ(scene.train.size(), 100u);
  EXPECT_EQ(scene.test.size(), 50u);
  EXPECT_TRUE(scene.renderings);
  // All cameras look at the origin, which is inside the chair.
  for (const SceneView& view : scene.train) {
    const Camera& c = view.camera;
    EXPECT_NEAR(c.fx * c.translation[0] / c.translation[2] + c.cx, 100, 1) << view.name;
    EXPECT_NEAR(c.fy * c.translation[1] / c.translation[2] + c.cy, 100, 1) << view.name;
  }
}

}  // namespace
}  // namespace cosplat

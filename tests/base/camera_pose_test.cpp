#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "splat/base/camera.h"

namespace cosplat {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<double, 9> kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};

TEST(CameraPose, TakesAGoodPose) {
  Camera camera;
  EXPECT_EQ(SetPose({0, -1, 0, 1, 0, 0, 0, 0, 1}, {1, 2, 3}, camera), "");
  EXPECT_EQ(camera.rotation, (std::array<float, 9>{0, -1, 0, 1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(camera.translation, (std::array<float, 3>{1, 2, 3}));
}

TEST(CameraPose, MakesARoundedRotationOrthonormal) {
  Camera camera;
  std::array<double, 9> rounded{0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1};
  for (double& x : rounded) x += 2e-4;
  ASSERT_EQ(SetPose(rounded, {0, 0, 0}, camera), "");
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      double dot = 0;
      for (int c = 0; c < 3; ++c)
        dot += double(camera.rotation[3 * i + c]) * camera.rotation[3 * k + c];
      EXPECT_NEAR(dot, i == k, 3e-7);
    }
}

TEST(CameraPose, SaysWhyAPoseIsBad) {
  Camera camera;
  auto rotation = kIdentity;
  rotation[4] = kNan;
  EXPECT_NE(SetPose(rotation, {0, 0, 0}, camera).find("not finite"), std::string::npos);
  EXPECT_NE(SetPose(kIdentity, {0, INFINITY, 0}, camera).find("translation"), std::string::npos);
  rotation[4] = 1.1;
  EXPECT_NE(SetPose(rotation, {0, 0, 0}, camera).find("1.21"), std::string::npos);
  rotation[4] = -1;
  EXPECT_NE(SetPose(rotation, {0, 0, 0}, camera).find("reflection"), std::string::npos);
  EXPECT_NE(SetPose({}, {0, 0, 0}, camera).find("not orthonormal"), std::string::npos);
}

// A camera at (0, 0, 5) with OpenGL's axes looks along -z, at the origin: the origin is 5 in front,
// a point above (world +y) is above in the image (OpenCV: -y).
TEST(CameraPose, TurnsOpenGlCamerasToOpenCv) {
  Camera camera;
  const std::array<double, 12> world_from_cam{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5};
  ASSERT_EQ(SetPoseFromOpenGlWorldFromCam(world_from_cam, camera), "");
  const auto in_camera = [&](std::array<float, 3> p, int row) {
    float value = camera.translation[row];
    for (int k = 0; k < 3; ++k) value += camera.rotation[3 * row + k] * p[k];
    return value;
  };
  EXPECT_FLOAT_EQ(in_camera({0, 0, 0}, 2), 5);
  EXPECT_FLOAT_EQ(in_camera({0, 1, 0}, 1), -1);
  EXPECT_FLOAT_EQ(in_camera({1, 0, 0}, 0), 1);
  EXPECT_FLOAT_EQ(camera.Center()[2], 5);
}

}  // namespace
}  // namespace cosplat

#include "flame/fit/head_crop.h"

#include <gtest/gtest.h>

#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

// A face of one size, px, about a place.
DetectedFace FaceAt(double x, double y, double size = 100) {
  return {{{x - size / 2, y - size / 2}, {x + size / 2, y + size / 2}}, 1, {}};
}

TEST(HeadCrop, HasRoomForHairAndShoulders) {
  const FrameCrop crop = HeadCrop({{FaceAt(900, 400)}, {FaceAt(940, 400)}}, 1920, 1080, 512);
  EXPECT_EQ(crop.side, 340);  // three faces, and the way between them
  EXPECT_EQ(crop.x, 750);
  EXPECT_NEAR(crop.y, 400 - 140 - 6, 1);
  EXPECT_EQ(crop.size, 340);  // not enlarged
  EXPECT_EQ(HeadCrop({{FaceAt(900, 400)}}, 1920, 1080, 256).size, 256);
}

TEST(HeadCrop, FollowsTheLargestFaceAndNoStray) {
  std::vector<std::vector<DetectedFace>> faces(64, {FaceAt(600, 500), FaceAt(1500, 500, 60)});
  faces[7] = {FaceAt(1700, 900)};
  faces[9].clear();
  const FrameCrop crop = HeadCrop(faces, 1920, 1080, 512);
  EXPECT_EQ(crop.side, 316);
  EXPECT_NEAR(crop.x + crop.side / 2, 600, 1);
}

TEST(HeadCrop, StaysInsideTheFrame) {
  for (const auto& [width, height] : {std::pair(720, 1280), {1280, 720}, {301, 200}}) {
    for (const double x : {0.0, 0.5, 1.0}) {
      const FrameCrop crop = HeadCrop({{FaceAt(x * width, 0.4 * height, 260)}}, width, height, 512);
      EXPECT_GE(crop.x, 0);
      EXPECT_GE(crop.y, 0);
      EXPECT_LE(crop.x + crop.side, width);
      EXPECT_LE(crop.y + crop.side, height);
      EXPECT_EQ(crop.side, std::min(width, height));
    }
  }
  test::ExpectError([] { HeadCrop({{}, {}}, 64, 64, 32); }, {"no frame has a face"});
}

// The lens of the square sees a point where the lens of the frame does.
TEST(FrameCrop, WholeCameraSeesTheSamePoint) {
  const FrameCrop crop{725, 238, 390, 1920, 1080, 256};
  Camera square;
  square.width = square.height = 256;
  square.fx = square.fy = 2304 * 256 / 390.0f;
  square.cx = (960 - 725) * 256 / 390.0f, square.cy = (540 - 238) * 256 / 390.0f;
  const Camera whole = crop.WholeCamera(square);
  EXPECT_EQ(whole.width, 1920);
  EXPECT_EQ(whole.height, 1080);
  EXPECT_NEAR(whole.cx, 960, 1e-3);
  EXPECT_NEAR(whole.cy, 540, 1e-3);
  for (const double u : {-0.2, 0.0, 0.31}) {
    const auto seen = [&](const Camera& c) {
      return std::array<double, 2>{c.fx * u + c.cx, c.fy * (u - 0.1) + c.cy};
    };
    const auto back = crop.InFrame(seen(square)), direct = seen(whole);
    EXPECT_NEAR(back[0], direct[0], 0.01);
    EXPECT_NEAR(back[1], direct[1], 0.01);
  }
}

}  // namespace
}  // namespace cosplat

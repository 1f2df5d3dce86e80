#include "flame/fit/head_crop.h"

#include <gtest/gtest.h>

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

// A face of one size, px, about a place.
DetectedFace FaceAt(double x, double y, double size = 100) {
  return {{{x - size / 2, y - size / 2}, {x + size / 2, y + size / 2}}, 1, {}};
}

TEST(HeadCrop, HasRoomForHairAndShoulders) {
  const FrameCrop crop = HeadCrop({{FaceAt(900, 400)}, {FaceAt(940, 400)}}, 1920, 1080, 512);
  EXPECT_EQ(crop.part.width, 340);  // three faces, and the way between them
  EXPECT_EQ(crop.part.height, 340);
  EXPECT_EQ(crop.part.x, 750);
  EXPECT_NEAR(crop.part.y, 400 - 140 - 6, 1);
  EXPECT_EQ(crop.width, 340);  // not enlarged
  EXPECT_EQ(HeadCrop({{FaceAt(900, 400)}}, 1920, 1080, 256).height, 256);
}

TEST(HeadCrop, FollowsNoStray) {
  std::vector<std::vector<DetectedFace>> faces(64, {FaceAt(600, 500)});
  faces[7] = {FaceAt(1700, 900)};
  faces[9].clear();
  const Crop part = HeadCrop(faces, 1920, 1080, 512).part;
  EXPECT_EQ(part.width, 316);
  EXPECT_NEAR(part.x + part.width / 2, 600, 1);
}

TEST(HeadCrop, PointsGoThereAndBack) {
  const FrameCrop crop = HeadCrop({{FaceAt(900, 400)}}, 1920, 1080, 200);
  const auto [x, y] = crop.InImage({900, 400});
  EXPECT_NEAR(x, 100, 1);  // in the middle
  const auto back = crop.InFrame({x, y});
  EXPECT_NEAR(back[0], 900, 1e-9);
  EXPECT_NEAR(back[1], 400, 1e-9);
}

TEST(HeadCrop, StaysInsideTheFrame) {
  for (const auto& [width, height] : {std::pair(720, 1280), {1280, 720}, {301, 200}}) {
    for (const double x : {0.0, 0.5, 1.0}) {
      const Crop part = HeadCrop({{FaceAt(x * width, 0.4 * height, 260)}}, width, height, 512).part;
      EXPECT_GE(part.x, 0);
      EXPECT_GE(part.y, 0);
      EXPECT_LE(part.x + part.width, width);
      EXPECT_LE(part.y + part.height, height);
    }
  }
  test::ExpectError([] { HeadCrop({{}, {}}, 64, 64, 32); }, {"no frame has a face"});
}

// A telephone held near: the frame is as wide as the face, and has its crown and chin.
TEST(HeadCrop, OfANarrowFrameKeepsItsHeight) {
  const FrameCrop crop = HeadCrop({{FaceAt(360, 640, 400)}}, 720, 1280, 512);
  EXPECT_EQ(crop.part.x, 0);
  EXPECT_EQ(crop.part.width, 720);
  EXPECT_EQ(crop.part.height, 1260);
  EXPECT_EQ(crop.part.y, 20);  // not the middle: less is needed above the face
  EXPECT_NEAR(crop.width * crop.height, 512 * 512, 512);
  EXPECT_NEAR(crop.scale_x() / crop.scale_y(), 1, 2e-3);
}

// Though the sides of its image are rounded.
TEST(HeadCrop, OfAnyShapeIsReadFromAFile) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "marks.json";
  for (const int width : {101, 333, 720, 1080})
    for (int height = 97; height < 4000; height += 389) {
      LandmarkVideo video;
      video.crop = HeadCrop({{FaceAt(500, 500, 4000)}}, width, height, 512);
      video.width = video.crop->width, video.height = video.crop->height;
      WriteLandmarks(path, video);
      const FrameCrop read = *ReadLandmarks(path).crop;
      EXPECT_EQ(read.part.width, width);
      EXPECT_EQ(read.part.height, height);
    }
}

// The lens of the part sees a point where the lens of the frame does.
TEST(FrameCrop, WholeCameraSeesTheSamePoint) {
  const FrameCrop crop{{725, 238, 390, 420}, 1920, 1080, 256, 276};
  Camera part;
  part.width = 256, part.height = 276;
  part.fx = 2304 * 256 / 390.0f, part.fy = 2304 * 276 / 420.0f;
  part.cx = (960 - 725) * 256 / 390.0f, part.cy = (540 - 238) * 276 / 420.0f;
  const Camera whole = crop.WholeCamera(part);
  EXPECT_EQ(whole.width, 1920);
  EXPECT_EQ(whole.height, 1080);
  EXPECT_NEAR(whole.cx, 960, 1e-3);
  EXPECT_NEAR(whole.cy, 540, 1e-3);
  for (const double u : {-0.2, 0.0, 0.31}) {
    const auto seen = [&](const Camera& c) {
      return std::array<double, 2>{c.fx * u + c.cx, c.fy * (u - 0.1) + c.cy};
    };
    const auto back = crop.InFrame(seen(part)), direct = seen(whole);
    EXPECT_NEAR(back[0], direct[0], 0.01);
    EXPECT_NEAR(back[1], direct[1], 0.01);
  }
}

}  // namespace
}  // namespace cosplat

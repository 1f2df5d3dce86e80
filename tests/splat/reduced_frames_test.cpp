// Smaller images for the first steps: the means of blocks, under a camera that sees the same.
#include "splat/train/subject/reduced_frames.h"

#include <gtest/gtest.h>

#include "splat/train/subject/scene_subject.h"
#include "tests/support/looking_at.h"

namespace cosplat {
namespace {

TrainFrame Frame(int width, int height, int channels) {
  TrainFrame frame{test::LookingAt({0, 0, 3}, {0, 0, 0}), Image8(width, height, channels)};
  frame.camera.width = width;
  frame.camera.height = height;
  for (size_t i = 0; i < frame.target.data.size(); ++i) frame.target.data[i] = uint8_t(7 * i % 251);
  return frame;
}

TEST(ReducedFrames, AreMeansOfBlocks) {
  const TrainFrame frame = Frame(7, 4, 3), half = Reduced(frame, 2);
  ASSERT_EQ(half.target.width, 3);  // what is left over is cut off
  ASSERT_EQ(half.target.height, 2);
  for (int c = 0; c < 3; ++c) {
    const Image8& t = frame.target;
    const double mean = (t.at(4, 2, c) + t.at(5, 2, c) + t.at(4, 3, c) + t.at(5, 3, c)) / 4.0;
    EXPECT_NEAR(half.target.at(2, 1, c), mean, 0.5);
  }
}

TEST(ReducedFrames, ColoursCountByTheirAlpha) {
  TrainFrame frame = Frame(2, 1, 4);
  frame.target.data = {200, 100, 0, 255, 10, 10, 10, 85};
  frame.target.height = frame.camera.height = 2;
  frame.target.data.resize(16, 0);  // and a clear row
  const Image8 one = Reduced(frame, 2).target;
  ASSERT_EQ(one.data.size(), 4u);
  EXPECT_EQ(one.data[0], (200 * 255 + 10 * 85 + 170) / 340);
  EXPECT_EQ(one.data[2], (10 * 85 + 170) / 340);
  EXPECT_EQ(one.data[3], 85);
  frame.target.data.assign(16, 0);
  EXPECT_EQ(Reduced(frame, 2).target.data, std::vector<uint8_t>(4, 0));
}

TEST(ReducedFrames, TheCameraSeesTheSame) {
  const Camera full = Frame(50, 34, 3).camera, third = Reduced(Frame(50, 34, 3), 3).camera;
  EXPECT_EQ(third.width, 16);
  EXPECT_EQ(third.height, 11);
  const float p[3] = {0.2f, -0.1f, 2.5f};  // in the camera's frame
  EXPECT_FLOAT_EQ(3 * (third.fx * p[0] / p[2] + third.cx), full.fx * p[0] / p[2] + full.cx);
  EXPECT_FLOAT_EQ(3 * (third.fy * p[1] / p[2] + third.cy), full.fy * p[1] / p[2] + full.cy);
}

TEST(ReducedFrames, KeepsThoseOfOneSize) {
  SceneSubject subject({Frame(40, 20, 3), Frame(40, 20, 3)}, 1);
  ReducedFrames frames(subject);
  EXPECT_EQ(&frames.At(1, 1), &subject.frame(1));
  EXPECT_EQ(frames.allocated_bytes(), 0u);
  EXPECT_EQ(frames.At(0, 2).target.width, 20);
  const TrainFrame* second = &frames.At(1, 2);
  EXPECT_EQ(&frames.At(1, 2), second);
  EXPECT_EQ(frames.allocated_bytes(), 2u * 20 * 10 * 3);
  EXPECT_EQ(frames.At(0, 4).target.width, 10);
  EXPECT_EQ(frames.allocated_bytes(), 10u * 5 * 3);
  frames.At(0, 1);
  EXPECT_EQ(frames.allocated_bytes(), 0u);
}

}  // namespace
}  // namespace cosplat

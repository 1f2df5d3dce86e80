// The real track in both layouts, and a real driving sequence, where they are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "flame/model.h"
#include "flame/pose.h"
#include "flame/track.h"

namespace cosplat {
namespace {

const std::string kData = COSPLAT_SOURCE_DIR "/../shared/data/";

using Pixels = std::vector<std::array<double, 2>>;

// Where the camera sees the posed mesh.
Pixels Project(const FlamePoser<float>& poser, const TrackedFrame& frame) {
  std::vector<float> v;
  poser.Forward(FlamePoser<float>::ParametersOf(frame.params), v);
  const Camera& c = frame.camera;
  Pixels pixels;
  for (size_t i = 0; i < v.size(); i += 3) {
    double q[3];
    for (int r = 0; r < 3; ++r) {
      q[r] = c.translation[r];
      for (int k = 0; k < 3; ++k) q[r] += double(c.rotation[3 * r + k]) * v[i + k];
    }
    EXPECT_GT(q[2], 0);
    pixels.push_back({c.fx * q[0] / q[2] + c.cx, c.fy * q[1] / q[2] + c.cy});
  }
  return pixels;
}

std::vector<TrackedFrame> AllFrames(const TrackedVideo& video) {
  std::vector<TrackedFrame> all = video.train;
  all.insert(all.end(), video.test.begin(), video.test.end());
  return all;
}

class RealTrack : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kData + "tracked/flame_for_tracks.npz"))
      GTEST_SKIP() << "no " << kData << "tracked: licensed data, not part of the project";
  }
};

TEST_F(RealTrack, BothLayoutsShowTheSameMesh) {
  const FlameModel model = LoadFlameModel(kData + "tracked/flame_for_tracks.npz");
  const TrackedVideo a = LoadTrackedVideo(kData + "tracked/wojtek_imavatar", {});
  // The second layout's images are links into the first, which copies of the data may have lost.
  const TrackedVideo b = LoadDrivingSequence(kData + "tracked/wojtek_vhap");
  EXPECT_EQ(a.train.size(), 160u);
  EXPECT_EQ(a.test.size(), 40u);
  EXPECT_EQ(b.train.size(), 170u);
  EXPECT_EQ(b.test.size(), 30u);
  EXPECT_TRUE(a.skipped.empty() && b.skipped.empty());
  const FlamePoser<float> poser_a(model, a.shape), poser_b(model, b.shape, b.static_offset);
  const std::vector<TrackedFrame> frames_a = AllFrames(a), frames_b = AllFrames(b);
  double worst = 0;
  for (size_t i = 0; i < frames_a.size(); i += 9) {
    const Pixels pa = Project(poser_a, frames_a[i]), pb = Project(poser_b, frames_b[i]);
    for (size_t k = 0; k < pa.size(); ++k)
      worst = std::max({worst, std::abs(pa[k][0] - pb[k][0]), std::abs(pa[k][1] - pb[k][1])});
  }
  // The files' doubles agree to 2e-5 px; float32 positions of a metre and focal 1500 px add 3e-4.
  EXPECT_LT(worst, 5e-4);
}

// The mesh lies on the head: nearly all of it inside the mask, and not so upside down.
TEST_F(RealTrack, TheMeshLiesInsideTheMask) {
  const FlameModel model = LoadFlameModel(kData + "tracked/flame_for_tracks.npz");
  const TrackedVideo video = LoadTrackedVideo(kData + "tracked/wojtek_imavatar", {});
  const FlamePoser<float> poser(model, video.shape);
  for (size_t i = 0; i < video.train.size(); i += 40) {
    const Image8 image = LoadTrackedImage(video, video.train[i]);
    const auto inside = [&](bool upside_down) {
      double count = 0;
      for (const auto& [x, y] : Project(poser, video.train[i])) {
        const int row = int(upside_down ? image.height - y : y);
        if (x >= 0 && row >= 0 && x < image.width && row < image.height)
          count += image.at(int(x), row, 3) > 127;
      }
      return count / model.vertex_count;
    };
    EXPECT_GT(inside(false), 0.95) << i;
    EXPECT_LT(inside(true), inside(false) - 0.02) << i;
  }
}

TEST_F(RealTrack, ADrivingSequenceIsInView) {
  const FlameModel model = LoadFlameModel(kData + "tracked/flame_for_tracks.npz");
  const TrackedVideo video = LoadDrivingSequence(kData + "flame/cap4d_sequence_00.npz");
  ASSERT_EQ(video.test.size(), 384u);
  EXPECT_EQ(video.test[0].params.expression.size(), 65u);
  TrackedFrame frame = video.test[0];
  frame.params.expression.clear();  // of another basis
  const FlamePoser<float> poser(model, {});
  double x_mean = 0, y_mean = 0;
  const Pixels pixels = Project(poser, frame);
  for (const auto& [x, y] : pixels) {
    x_mean += x / pixels.size();
    y_mean += y / pixels.size();
  }
  EXPECT_NEAR(x_mean, 256, 60);
  EXPECT_NEAR(y_mean, 256, 120);
}

}  // namespace
}  // namespace cosplat

// First points from images alone: on the surface that they show, and the same for any number
// of threads.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "splat/train/start/initialize.h"
#include "tests/support/looking_at.h"

namespace cosplat {
namespace {

using test::Point;

constexpr float kRadius = 0.8f;

// A ball around the origin with a pattern that no two places share.
TrainFrame PhotographOfBall(const Camera& camera) {
  TrainFrame frame{camera, Image8(camera.width, camera.height, 4)};
  const auto eye = camera.Center();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const float in_camera[3] = {
          (float(x) + 0.5f - camera.cx) / camera.fx, (float(y) + 0.5f - camera.cy) / camera.fy, 1};
      Point ray{};
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) ray[i] += camera.rotation[3 * k + i] * in_camera[k];
      ray = test::Unit(ray);
      const float b = eye[0] * ray[0] + eye[1] * ray[1] + eye[2] * ray[2];
      const float c = eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2] - kRadius * kRadius;
      if (b * b < c) continue;
      const float t = -b - std::sqrt(b * b - c);
      for (int i = 0; i < 3; ++i) {
        const float p[3] = {eye[0] + t * ray[0], eye[1] + t * ray[1], eye[2] + t * ray[2]};
        const float wave = std::sin(7 * p[i] + 3 * p[(i + 1) % 3]) * std::cos(11 * p[(i + 2) % 3]);
        frame.target.at(x, y, i) = uint8_t(128 + 120 * wave);
      }
      frame.target.at(x, y, 3) = 255;
    }
  return frame;
}

struct Swept {
  std::vector<float> points;
  std::vector<uint8_t> colors;
};

Swept Sweep(size_t rays) {
  std::vector<TrainFrame> frames;
  for (const Camera& camera : test::Ring(16, 2.5f, 96)) frames.push_back(PhotographOfBall(camera));
  Rng rng{4};
  Swept swept;
  SweepPoints(frames, rays, rng, swept.points, swept.colors);
  return swept;
}

TEST(SweepPoints, LieOnTheSurfaceInItsColours) {
  const Swept swept = Sweep(3000);
  const size_t count = swept.points.size() / 3;
  ASSERT_EQ(swept.colors.size(), swept.points.size());
  EXPECT_GT(count, 800u);  // about half of the rays meet the ball
  size_t near = 0;
  for (size_t i = 0; i < count; ++i) {
    const float* p = &swept.points[3 * i];
    near += std::abs(std::hypot(p[0], p[1], p[2]) - kRadius) < 0.05f;
  }
  EXPECT_GT(double(near), 0.9 * double(count));
  const auto [low, high] = std::minmax_element(swept.colors.begin(), swept.colors.end());
  EXPECT_LT(*low, 40);
  EXPECT_GT(*high, 215);
}

TEST(SweepPoints, NoneWhereNothingCanBeToldApart) {
  std::vector<TrainFrame> frames;
  for (const Camera& camera : test::Ring(16, 2.5f, 96))
    frames.push_back({camera, Image8(96, 96, 3, 200)});
  Rng rng{4};
  Swept swept;
  SweepPoints(frames, 1000, rng, swept.points, swept.colors);
  EXPECT_TRUE(swept.points.empty());
}

TEST(SweepPoints, AreTheSameForAnyNumberOfThreads) {
  const Swept all = Sweep(500);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const Swept one = Sweep(500);
  EXPECT_EQ(all.points, one.points);
  EXPECT_EQ(all.colors, one.colors);
}

TEST(SweepPoints, NoneWithoutNeighbours) {
  Rng rng{1};
  Swept swept;
  SweepPoints({}, 100, rng, swept.points, swept.colors);
  const TrainFrame one = PhotographOfBall(test::Ring(1, 2.5f, 40)[0]);
  SweepPoints({one, one}, 100, rng, swept.points, swept.colors);  // in one place
  EXPECT_TRUE(swept.points.empty());
}

}  // namespace
}  // namespace cosplat

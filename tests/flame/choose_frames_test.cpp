#include "flame/fit/choose_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace cosplat {
namespace {

TEST(FramesToLookAt, AreAllOfAShortVideo) {
  for (const int wanted : {0, 10, 12}) {
    const FrameSelection look = FramesToLookAt(10, wanted, 25);
    EXPECT_EQ(look.frames.size(), 10u);
    EXPECT_EQ(look.held_out, 0);
  }
}

TEST(FramesToLookAt, HoldOutTheEndOfALongOne) {
  for (const auto& [total, rate] :
       {std::pair(size_t(18000), 30.0), {size_t(2400), 240.0}, {size_t(405), 24.0}}) {
    const FrameSelection look = FramesToLookAt(total, 400, rate);
    ASSERT_EQ(look.held_out, 80);
    const std::vector<size_t>& f = look.frames;
    EXPECT_TRUE(std::is_sorted(f.begin(), f.end()));
    EXPECT_TRUE(std::adjacent_find(f.begin(), f.end()) == f.end());
    EXPECT_LT(f.back(), total);
    EXPECT_EQ(f[0], 0u);
    // One after the other at no more than 30 a second, near the end.
    const size_t step = f.back() - f[f.size() - 2];
    EXPECT_EQ(step, rate == 240 ? 6u : 1u);
    EXPECT_GE(f.back() + step, total);
    EXPECT_EQ(f.back() - f[f.size() - 80], 79 * step);
    EXPECT_EQ(f.size() - 80, total > 2000 ? 640u : 320u);
  }
}

// A face whose mouth is open by so much and that is turned by so much.
DetectedFace Face(double open, double turned) {
  DetectedFace face;
  for (int i = 0; i < 68; ++i)
    face.points.push_back({100 + (i % 9) * 10 * std::cos(turned), 100.0 + (i / 9) * 10});
  for (int i = 50; i < 68; ++i) face.points[size_t(i)][1] += open;
  return face;
}

struct Looks {
  LandmarkVideo video;
  std::vector<double> sharpness;

  // Of 60 frames, the last ten for testing, one opens the mouth and one is turned.
  Looks() : sharpness(60, 10) {
    video.set = LandmarkSet::kIbug68;
    video.held_out = 10;
    for (int f = 0; f < 60; ++f)
      video.frames.push_back(
          {std::to_string(f), f, {Face(f == 23 ? 30 : 0.01 * f, f == 37 ? 0.8 : 0)}, ""});
  }
};

TEST(ChooseFrames, TakesThoseThatDiffer) {
  const Looks looks;
  const std::vector<size_t> chosen = ChooseFrames(looks.video, looks.sharpness, 20);
  ASSERT_EQ(chosen.size(), 20u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  for (size_t i = 0; i < 10; ++i) EXPECT_EQ(chosen[10 + i], 50 + i);
  for (const size_t rare : {23, 37})
    EXPECT_TRUE(std::binary_search(chosen.begin(), chosen.end(), rare)) << rare;
  EXPECT_EQ(chosen, ChooseFrames(looks.video, looks.sharpness, 20));
}

TEST(ChooseFrames, TakesBlurredAndFacelessOnesLast) {
  Looks looks;
  looks.sharpness[23] = 1;
  looks.video.frames[37].faces.clear();
  const auto has = [&](int wanted, size_t f) {
    const auto chosen = ChooseFrames(looks.video, looks.sharpness, wanted);
    EXPECT_EQ(chosen.size(), size_t(wanted));
    return std::binary_search(chosen.begin(), chosen.end(), f);
  };
  EXPECT_FALSE(has(58, 23));
  EXPECT_FALSE(has(58, 37));
  EXPECT_TRUE(has(60, 23));
  EXPECT_TRUE(has(60, 37));
}

}  // namespace
}  // namespace cosplat

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

TEST(SharpnessOf, IsThatOfTheFace) {
  Image8 sharp(64, 64, 3, 100), soft = sharp;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) {
        sharp.at(x, y, c) = x % 2 ? 200 : 50;
        soft.at(x, y, c) = uint8_t(x < 30 ? 3 * x : (x % 2 ? 200 : 50));
      }
  const std::vector<std::array<double, 2>> face{{4, 4}, {28, 60}};
  EXPECT_GT(SharpnessOf(sharp, face), 100 * SharpnessOf(soft, face));
  EXPECT_EQ(SharpnessOf(sharp, {{-50, -50}, {-20, -20}}), 0);
}

// Of a grey face with a dark half, which moves to where the landmarks are.
TEST(FaceColorsOf, AreThoseOfItsParts) {
  Image8 image(64, 64, 3, 10);
  for (int y = 20; y < 60; ++y)
    for (int x = 8; x < 48; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = uint8_t(x < 28 ? 50 : 200 + c);
  const std::vector<float> colors = FaceColorsOf(image, {{8, 20}, {48, 60}});
  ASSERT_EQ(colors.size(), 48u);
  for (size_t part = 0; part < 16; ++part)
    for (size_t c = 0; c < 3; ++c)
      EXPECT_EQ(colors[3 * part + c], part % 4 < 2 ? 50 : float(200 + c)) << part;
  EXPECT_EQ(FaceColorsOf(image, {{-50, -50}, {-20, -20}}), std::vector<float>(48, -1));
}

TEST(OtherLooks, AreFoundWhereAnotherPersonBegins) {
  const auto colors = [](const std::function<float(int)>& of) {
    std::vector<std::vector<float>> all;
    for (int i = 0; i < 60; ++i)
      all.push_back(std::vector<float>(48, of(i) + 3 * std::sin(0.7f * float(i))));
    return all;
  };
  EXPECT_EQ(OtherLooks(colors([](int i) { return i < 40 ? 100 : 130; })), std::vector<size_t>{40});
  EXPECT_EQ(OtherLooks(colors([](int) { return 100; })), std::vector<size_t>{});
  EXPECT_EQ(OtherLooks(colors([](int i) { return i == 40 ? 160 : 100; })), std::vector<size_t>{})
      << "a flash";
  EXPECT_EQ(OtherLooks(colors([](int i) { return 100 + 2 * float(i); })), std::vector<size_t>{})
      << "a light that grows";
  EXPECT_EQ(OtherLooks({}), std::vector<size_t>{});
  auto leaving = colors([](int) { return 100; });
  for (size_t i = 40; i < leaving.size(); ++i) std::fill_n(leaving[i].begin(), 24, -1);
  EXPECT_EQ(OtherLooks(leaving), std::vector<size_t>{}) << "half of it beyond the image";
}

}  // namespace
}  // namespace cosplat

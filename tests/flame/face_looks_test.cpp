// What a face looks like in a frame.
#include "flame/fit/face_looks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace cosplat {
namespace {

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

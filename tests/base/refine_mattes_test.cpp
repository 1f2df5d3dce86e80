// A disc that stands for a head, before made backgrounds, with mattes that are off.
#include "splat/media/refine_mattes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "splat/base/rng.h"
#include "splat/media/image_filters.h"
#include "splat/media/image_io.h"
#include "splat/media/still_background.h"

namespace cosplat {
namespace {

constexpr int kSide = 96, kFrames = 12;
constexpr float kRadius = 22;

struct Scene {
  std::vector<Image8> images, truths, mattes;
  std::vector<float> x;  // of the disc's middle, px

  MatteRefiner Refiner() const {
    return MatteRefiner({int(images.size()),
                         [this](int f) { return images[size_t(f)]; },
                         [this](int f) { return mattes[size_t(f)]; },
                         [this](int f) {
                           const double at = x[size_t(f)];
                           return FaceBox{at - 8, 36, at + 8, 56};
                         },
                         2});
  }
  double Error(const std::vector<Image8>& found) const {
    double sum = 0;
    for (size_t f = 0; f < truths.size(); ++f)
      for (size_t i = 0; i < truths[f].data.size(); ++i)
        sum += std::abs(double(found[f].data[i]) - truths[f].data[i]) / 255;
    return sum / double(truths.size() * truths[0].data.size());
  }
  std::vector<Image8> Refined() const {
    const MatteRefiner refiner = Refiner();
    std::vector<Image8> found;
    for (int f = 0; f < int(images.size()); ++f) found.push_back(refiner.Refine(f));
    return found;
  }
};

float Covered(float distance) { return std::clamp(kRadius - distance + 0.5f, 0.f, 1.f); }

// speed: of the disc, pan: of the background, px a frame. The network's disc is `off` px too far to
// the right, and blurred.
Scene MakeScene(float speed, float pan, float off) {
  Scene scene;
  Rng rng{5};
  for (int f = 0; f < kFrames; ++f) {
    const float middle = 30 + speed * float(f);
    Image image(kSide, kSide, 3), truth(kSide, kSide, 1), matte(kSide, kSide, 1);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const float alpha = Covered(std::hypot(float(x) - middle, float(y) - 46));
        const float u = float(x) + pan * float(f);
        const float behind = 0.35f + 0.2f * std::sin(0.4f * u) * std::cos(0.3f * float(y));
        const float skin = 0.8f + 0.05f * std::sin(float(x) - middle);
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = alpha * (c == 0 ? skin : 0.7f * skin) +
                              (1 - alpha) * (c == 2 ? behind : 0.8f * behind) + rng.Normal() / 255;
        truth.at(x, y, 0) = alpha;
        matte.at(x, y, 0) = Covered(std::hypot(float(x) - middle - off, float(y) - 46));
      }
    scene.images.push_back(ToBytes(image));
    scene.truths.push_back(ToBytes(truth));
    scene.mattes.push_back(ToBytes(BoxMean(matte, 2)));
    scene.x.push_back(middle);
  }
  return scene;
}

void Draw(Image8& matte, int left, int top, int side, uint8_t value) {
  for (int y = top; y < top + side; ++y)
    for (int x = left; x < left + side; ++x) matte.at(x, y, 0) = value;
}

TEST(ImageFilters, MeansOfSquares) {
  Image image(5, 5, 2);
  image.at(2, 2, 0) = 9;
  for (size_t i = 1; i < image.data.size(); i += 2) image.data[i] = 4;
  const Image mean = BoxMean(image, 1);
  EXPECT_NEAR(mean.at(1, 3, 0), 1, 1e-6);
  EXPECT_NEAR(mean.at(0, 0, 0), 0, 1e-6);
  EXPECT_NEAR(mean.at(0, 4, 1), 4, 1e-6);  // mirrored beyond the rim
}

TEST(ImageFilters, PartsTouchBySides) {
  Image8 mask(4, 2, 1);
  mask.at(0, 0, 0) = mask.at(0, 1, 0) = mask.at(1, 0, 0) = 1;
  mask.at(2, 1, 0) = 255;
  const ConnectedParts parts = PartsOf(mask);
  EXPECT_EQ(parts.count, 2);
  EXPECT_EQ(parts.labels[0], parts.labels[1]);
  EXPECT_EQ(parts.labels[0], parts.labels[4]);
  EXPECT_NE(parts.labels[0], parts.labels[6]);
  EXPECT_EQ(parts.labels[3], 0);
}

// A linear function of the colours is left as it is; with one colour the weighted mean is all that
// can be said.
TEST(ImageFilters, GuidedFilterFitsColors) {
  Rng rng{3};
  Image guide(20, 20, 3), input(20, 20, 1), weight(20, 20, 1);
  for (size_t i = 0; i < guide.pixels(); ++i) {
    for (size_t c = 0; c < 3; ++c) guide.data[3 * i + c] = rng.Uniform();
    input.data[i] = 0.1f + 0.5f * guide.data[3 * i] - 0.3f * guide.data[3 * i + 1] +
                    0.2f * guide.data[3 * i + 2];
    weight.data[i] = 0.1f + rng.Uniform();
  }
  const Image fit = GuidedFilter(guide, input, weight, 3, 1e-8f);
  for (size_t i = 0; i < input.data.size(); ++i) EXPECT_NEAR(fit.data[i], input.data[i], 1e-4);

  const Image flat(20, 20, 3, 0.5f);
  Image half(20, 20, 1);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) half.at(x, y, 0) = x < 10 ? 1.f : 0.f;
  for (size_t i = 0; i < half.data.size(); ++i) weight.data[i] = half.data[i] > 0 ? 3.f : 1.f;
  const Image mean = GuidedFilter(flat, half, weight, 40, 1e-3f);
  EXPECT_NEAR(mean.at(4, 4, 0), 0.75, 0.03);
}

TEST(StillBackground, IsWhatClearFramesAgreeOn) {
  std::vector<Image8> frames(10, Image8(3, 1, 3, 100)), clear(10, Image8(3, 1, 1, 1));
  for (size_t f = 0; f < 10; ++f) {
    if (f < 6) frames[f].at(0, 0, 1) = 220, clear[f].at(0, 0, 0) = 0;  // somebody is in front
    frames[f].at(1, 0, 2) = uint8_t(20 * f);                           // never the same
    if (f < 7) clear[f].at(2, 0, 0) = 0;                               // seen in three
  }
  const StillBackground found = FindStillBackground(frames, clear);
  EXPECT_NEAR(found.color.at(0, 0, 1), 100 / 255.0, 1e-6);
  EXPECT_GT(found.noise.at(0, 0, 0), 0);
  EXPECT_LT(found.noise.at(1, 0, 0), 0);
  EXPECT_LT(found.noise.at(2, 0, 0), 0);
}

TEST(RefineMattes, KeepTheFacesPartAndFillItsHoles) {
  Scene scene = MakeScene(0, 0, 0);
  for (Image8& matte : scene.mattes) {
    Draw(matte, 74, 70, 16, 255);  // somebody else
    Draw(matte, 28, 44, 4, 0);     // an eye
  }
  for (const Image8& matte : scene.Refined()) {
    EXPECT_EQ(matte.at(82, 78, 0), 0);
    EXPECT_GT(matte.at(30, 46, 0), 250);
    EXPECT_GT(matte.at(24, 40, 0), 250);
  }
  // The background is seen through an arm akimbo.
  scene = MakeScene(0, 0, 0);
  for (Image8& matte : scene.mattes) {
    Draw(matte, 20, 58, 36, 255);
    Draw(matte, 34, 72, 12, 0);
  }
  for (const Image8& matte : scene.Refined()) EXPECT_EQ(matte.at(40, 78, 0), 0);
}

// Two whose shoulders touch are one part; each has the side that is nearer, by their faces' sizes.
TEST(RefineMattes, WhoIsBesideIsLeftOut) {
  Image8 matte(100, 60, 1);
  std::fill(matte.data.begin(), matte.data.end(), uint8_t(255));
  const FaceBox ours{10, 10, 30, 30}, theirs{70, 10, 80, 20};
  Image8 same = matte;
  LeaveToOthers(ours, {}, same);
  EXPECT_EQ(same.data, matte.data);
  LeaveToOthers(ours, {theirs}, matte);
  EXPECT_EQ(matte.at(20, 20, 0), 255);
  EXPECT_EQ(matte.at(50, 20, 0), 255);  // 30 px of 20, 25 px of 10
  EXPECT_EQ(matte.at(60, 20, 0), 0);
  EXPECT_EQ(matte.at(20, 59, 0), 255);
}

TEST(RefineMattes, WithoutAFaceTheLargestPartIsKept) {
  Scene scene = MakeScene(0, 0, 0);
  for (Image8& matte : scene.mattes) Draw(matte, 74, 70, 16, 255);
  const MatteRefiner refiner({kFrames,
                              [&](int f) { return scene.images[size_t(f)]; },
                              [&](int f) { return scene.mattes[size_t(f)]; },
                              [](int) { return std::nullopt; },
                              2});
  const Image8 found = refiner.Refine(3);
  EXPECT_EQ(found.at(82, 78, 0), 0);
  EXPECT_GT(found.at(30, 46, 0), 250);
  const MatteRefiner empty({2,
                            [&](int f) { return scene.images[size_t(f)]; },
                            [](int) { return Image8(kSide, kSide, 1); },
                            [](int) {
                              return FaceBox{20, 36, 40, 56};
                            },
                            2});
  EXPECT_EQ(empty.Refine(0).data, Image8(kSide, kSide, 1).data);
}

TEST(RefineMattes, RimsFollowTheFrameWhereNothingIsKnownOfTheBackground) {
  const Scene still = MakeScene(0, 0, 2.5f);  // the disc hides the same all the time
  EXPECT_GT(still.Error(still.mattes), 0.02);
  EXPECT_LT(still.Error(still.Refined()), 0.3 * still.Error(still.mattes));
  const Scene moving = MakeScene(2, 5.3f, 2.5f);  // nothing of the background is at rest
  EXPECT_LT(moving.Error(moving.Refined()), 0.3 * moving.Error(moving.mattes));
}

TEST(RefineMattes, KnownBackgroundsDecide) {
  const Scene scene = MakeScene(3, 0, 2.5f);
  EXPECT_LT(scene.Error(scene.Refined()), 0.1 * scene.Error(scene.mattes));
}

TEST(RefineMattes, WhoDoesNotMoveStays) {
  const Scene scene = MakeScene(0, 0, 0);
  for (const Image8& matte : scene.Refined())
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const float distance = std::hypot(float(x) - 30, float(y) - 46);
        if (distance < kRadius - 3) {
          EXPECT_GT(matte.at(x, y, 0), 250) << x << " " << y;
        }
        if (distance > kRadius + 5) {
          EXPECT_EQ(matte.at(x, y, 0), 0) << x << " " << y;
        }
      }
}

// A lectern: half in for the network, and at rest; and somebody behind it, at rest too.
TEST(RefineMattes, WhatNeverMovesGoesOut) {
  for (const float speed : {0.f, 1.f}) {
    Scene scene = MakeScene(speed, 0, 0);
    for (int f = 0; f < kFrames; ++f)
      for (int y = 62; y < 90; ++y)
        for (int x = 4; x < 90; ++x) {
          for (int c = 0; c < 3; ++c)
            scene.images[size_t(f)].at(x, y, c) = uint8_t(40 + (x + y) % 2);
          scene.truths[size_t(f)].at(x, y, 0) = 0;
          scene.mattes[size_t(f)].at(x, y, 0) = x < 40 ? 150 : f % 2 == 0 ? 130 : 240;
        }
    const std::vector<Image8> found = scene.Refined();
    for (int f = 0; f < kFrames; ++f) {
      for (int y = 66; y < 88; ++y)
        for (int x = 6; x < 88; ++x) EXPECT_LT(found[size_t(f)].at(x, y, 0), 10) << x << " " << y;
      const int middle = int(scene.x[size_t(f)]);
      EXPECT_GT(found[size_t(f)].at(middle, 56, 0), 250);
      EXPECT_GT(found[size_t(f)].at(middle - 16, 44, 0), 250);
    }
    // A hand before it moves.
    for (int y = 70; y < 80; ++y)
      for (int x = 30; x < 44; ++x) {
        for (int c = 0; c < 3; ++c) scene.images[5].at(x, y, c) = uint8_t(c == 0 ? 210 : 150);
        scene.mattes[5].at(x, y, 0) = 255;
      }
    for (int y = 60; y < 72; ++y)
      for (int x = 34; x < 40; ++x) {
        for (int c = 0; c < 3; ++c) scene.images[5].at(x, y, c) = uint8_t(c == 0 ? 210 : 150);
        scene.mattes[5].at(x, y, 0) = 255;
      }
    EXPECT_GT(scene.Refiner().Refine(5).at(37, 75, 0), 200);
  }
}

TEST(RefineMattes, AreTheSameForAnyNumberOfThreads) {
  const Scene scene = MakeScene(3, 0, 2.5f);
  const std::vector<Image8> many = scene.Refined();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<Image8> few = scene.Refined();
  for (size_t f = 0; f < many.size(); ++f) EXPECT_EQ(many[f].data, few[f].data);
}

}  // namespace
}  // namespace cosplat

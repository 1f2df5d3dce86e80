// avatar/play/preview.h: where the wide pixels lie, how they are enlarged, and what it costs.
#include "avatar/play/preview.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "assets/head/motion.h"
#include "avatar/play/player.h"
#include "splat/math/pinhole.h"
#include "splat/train/loss/loss.h"

namespace cosplat::test {
namespace {

constexpr int kSizes[][2] = {{1, 1}, {2, 2}, {1, 6}, {7, 1}, {3, 3}, {8, 6}, {9, 14}, {64, 33}};

// An image at half resolution with `value(plane, x, y)` in pixel (x, y); plane 3: transmittance.
template <class F>
RenderedImage HalfImage(int width, int height, const F& value) {
  RenderedImage half;
  half.width = (width + 1) / 2;
  half.height = (height + 1) / 2;
  for (int plane = 0; plane < 4; ++plane)
    for (int y = 0; y < half.height; ++y)
      for (int x = 0; x < half.width; ++x)
        (plane < 3 ? half.color : half.transmittance).push_back(value(plane, x, y));
  return half;
}

float At(const RenderedImage& image, int plane, int x, int y) {
  const size_t pixel = size_t(y) * image.width + x;
  return plane < 3 ? image.color[size_t(plane) * image.width * image.height + pixel]
                   : image.transmittance[pixel];
}

TEST(Preview, HalvesWhereAPointIsSeen) {
  Camera camera = procedural::OrbitCamera(0.3f, 0.1f, 0.8f, 101);
  camera.height = 64;
  const Camera half = HalfResolution(camera);
  EXPECT_EQ(half.width, 51);
  EXPECT_EQ(half.height, 32);
  EXPECT_EQ(half.rotation, camera.rotation);
  EXPECT_EQ(half.translation, camera.translation);
  for (const float x : {-0.1f, 0.0f, 0.2f}) {  // px = f x / z + c
    EXPECT_EQ(half.fx * x + half.cx, 0.5f * (camera.fx * x + camera.cx));
    EXPECT_EQ(half.fy * x + half.cy, 0.5f * (camera.fy * x + camera.cy));
  }
  camera.width = camera.height = 1;
  EXPECT_EQ(HalfResolution(camera).width, 1);
  EXPECT_EQ(HalfResolution(camera).height, 1);
}

TEST(Preview, AFlatImageStaysExactlyAsItIs) {
  for (const auto& [width, height] : kSizes) {
    RenderedImage out;
    EnlargeTwice(HalfImage(width, height, [](int plane, int, int) { return 0.1f + 0.3f * plane; }),
                 width,
                 height,
                 out);
    ASSERT_EQ(out.width, width);
    ASSERT_EQ(out.height, height);
    ASSERT_EQ(out.color.size(), size_t(3 * width * height));
    ASSERT_EQ(out.transmittance.size(), size_t(width * height));
    for (int plane = 0; plane < 4; ++plane)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) ASSERT_EQ(At(out, plane, x, y), 0.1f + 0.3f * plane);
  }
}

// The definition: bilinear at the pixel's centre, with the outermost pixels repeated.
TEST(Preview, IsBilinearBetweenTheCentresOfItsPixels) {
  for (const auto& [width, height] : kSizes) {
    Rng rng{7};
    const RenderedImage half =
        HalfImage(width, height, [&](int, int, int) { return rng.Uniform(); });
    RenderedImage out;
    EnlargeTwice(half, width, height, out);
    const auto sample = [&](int plane, int x, int y) {
      return double(
          At(half, plane, std::clamp(x, 0, half.width - 1), std::clamp(y, 0, half.height - 1)));
    };
    for (int plane = 0; plane < 4; ++plane)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const double u = (x + 0.5) / 2 - 0.5, v = (y + 0.5) / 2 - 0.5;
          const int i = int(std::floor(u)), j = int(std::floor(v));
          const double s = u - i, t = v - j;
          const double expected =
              (1 - t) * ((1 - s) * sample(plane, i, j) + s * sample(plane, i + 1, j)) +
              t * ((1 - s) * sample(plane, i, j + 1) + s * sample(plane, i + 1, j + 1));
          // Three roundings of numbers below 1.
          ASSERT_NEAR(At(out, plane, x, y), expected, 2e-7) << width << "x" << height;
        }
  }
}

TEST(Preview, HasTheSameBitsForAnyNumberOfThreads) {
  Rng rng{8};
  const RenderedImage half = HalfImage(75, 301, [&](int, int, int) { return rng.Uniform(); });
  RenderedImage expected, out;
  EnlargeTwice(half, 75, 301, expected);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  EnlargeTwice(half, 75, 301, out);
  EXPECT_EQ(out.color, expected.color);
  EXPECT_EQ(out.transmittance, expected.transmittance);
}

class PreviewPlayer : public testing::Test {
 protected:
  static const ProceduralHead& Head() {
    static const ProceduralHead head = MakeProceduralHeadParts();
    return head;
  }
  const AvatarModel avatar_ = PaintedAvatar(Head(), 6000);
  Player full_{avatar_, Head().model};
  Player preview_{avatar_, Head().model, {true}};
};

TEST_F(PreviewPlayer, DrawsAnySize) {
  for (const auto& [width, height] : kSizes) {
    Camera camera = procedural::OrbitCamera(0, 0, 0.8f, width);
    camera.height = height;
    camera.cy = 0.5f * float(height);
    const Image8 bytes = preview_.Render({}, camera);
    ASSERT_EQ(bytes.width, width);
    ASSERT_EQ(bytes.height, height);
    RenderedImage image;
    preview_.RenderOver({}, camera, {1, 1, 1}, image);
    for (const float t : image.transmittance) ASSERT_TRUE(t >= 0 && t <= 1);
    for (const float c : image.color) ASSERT_TRUE(std::isfinite(c));
  }
}

// Nothing is moved: a preview of an image without detail is the image.
TEST_F(PreviewPlayer, IsCloseToTheFullImage) {
  for (const int size : {256, 255}) {
    double worst_color = 100, worst_alpha = 100;
    for (const float azimuth : {-0.6f, 0.0f, 0.6f}) {
      const Camera camera = procedural::OrbitCamera(azimuth, 0, 0.8f, size);
      RenderedImage full, preview;
      full_.RenderOver({}, camera, {1, 1, 1}, full);
      preview_.RenderOver({}, camera, {1, 1, 1}, preview);
      worst_color = std::min(worst_color, Psnr(preview.color, full.color));
      worst_alpha = std::min(worst_alpha, Psnr(preview.transmittance, full.transmittance));
    }
    // Measured: 29.3 and 25.3 dB (small Gaussians blur, and with them the gaps between them).
    EXPECT_GT(worst_color, 29);
    EXPECT_GT(worst_alpha, 25);
  }
}

}  // namespace
}  // namespace cosplat::test

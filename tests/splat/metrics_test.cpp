// Evaluation of images: known values, masks, regions, sizes that disagree.
#include "splat/eval/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/rng.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

TEST(CompareImages, KnownValues) {
  const Image8 black(20, 15, 3), grey(20, 15, 3, 51);  // 0.2 apart: 10 log10(25)
  const ImageMetrics m = CompareImages(grey, black);
  EXPECT_NEAR(m.psnr, 13.9794, 1e-4);
  EXPECT_LT(m.ssim, 0.01);
  EXPECT_FALSE(m.psnr_mask);
  const ImageMetrics same = CompareImages(grey, grey);
  EXPECT_EQ(same.psnr, 100);
  EXPECT_NEAR(same.ssim, 1, 1e-6);
}

TEST(CompareImages, TheMaskWeighs) {
  Image8 truth(4, 1, 3), rendered(4, 1, 3);
  for (int c = 0; c < 3; ++c) {
    rendered.at(0, 0, c) = 51;   // 0.2 off, weight 1
    rendered.at(1, 0, c) = 255;  // 1 off, weight 0
    rendered.at(2, 0, c) = 0;    // right, weight 0.6
  }
  Image8 mask(4, 1, 1);
  mask.data = {255, 0, 153, 0};
  const ImageMetrics m = CompareImages(rendered, truth, &mask);
  EXPECT_NEAR(m.psnr_mask.value(), -10 * std::log10(0.04 / 1.6), 1e-6);
  mask.data = {0, 0, 255, 0};
  EXPECT_EQ(CompareImages(rendered, truth, &mask).psnr_mask, 100);
  mask.data = {0, 0, 0, 0};
  EXPECT_FALSE(CompareImages(rendered, truth, &mask).psnr_mask) << "nothing to compare";
}

TEST(CompareImages, TheHighlightIsTheBrightestFiftiethOfTheMask) {
  // 10 x 10: two pixels are the brightest fiftieth; a brighter one is outside the mask.
  Image8 truth(10, 10, 3, 40), rendered = truth, mask(10, 10, 1, 255);
  for (int c = 0; c < 3; ++c) {
    truth.at(0, 0, c) = 255, mask.at(0, 0, 0) = 254;
    truth.at(3, 4, c) = 200, rendered.at(3, 4, c) = 149;  // 0.2 apart
    truth.at(7, 7, c) = 190, rendered.at(7, 7, c) = 190;
    rendered.at(5, 5, c) = 0;  // dark: does not count
  }
  const ImageMetrics m = CompareImages(rendered, truth, &mask);
  EXPECT_NEAR(
      m.psnr_highlight.value(), -10 * std::log10(0.04), 1e-4);  // of 99 pixels a fiftieth is one
  EXPECT_FALSE(CompareImages(rendered, truth).psnr_highlight);
}

TEST(MaskedPsnr, ABoxIsCutToTheImage) {
  Image8 truth(6, 6, 3), rendered(6, 6, 3);
  for (int c = 0; c < 3; ++c) rendered.at(5, 5, c) = 255;
  const auto inside = [&](const Crop& box) {
    return MaskedPsnr(rendered, truth, Inside(Image8(6, 6, 1, 255), box));
  };
  EXPECT_NEAR(inside({4, 4, 10, 10}).value(), -10 * std::log10(0.25), 1e-9);
  EXPECT_EQ(inside({-5, 0, 8, 6}), 100);
  EXPECT_FALSE(inside({10, 10, 3, 3}));
}

TEST(CompareImages, SizesThatDisagree) {
  const Image8 a(4, 3, 3), b(3, 4, 3), rgba(4, 3, 4), mask(4, 4, 1), rgb_mask(4, 3, 3);
  test::ExpectError([&] { CompareImages(a, b); }, {"images", "4x3x3", "3x4x3"});
  test::ExpectError([&] { CompareImages(rgba, a); }, {"4x3x4"});
  test::ExpectError([&] { CompareImages(a, a, &mask); }, {"mask", "4x4x1"});
  test::ExpectError([&] { CompareImages(a, a, &rgb_mask); }, {"mask", "4x3x3"});
}

TEST(CompareImages, OnePixel) {
  const Image8 a(1, 1, 3, 10), b(1, 1, 3, 20);
  const ImageMetrics m = CompareImages(a, b);
  EXPECT_NEAR(m.psnr, 20 * std::log10(25.5), 1e-4);
  EXPECT_TRUE(std::isfinite(m.ssim));
}

}  // namespace
}  // namespace cosplat

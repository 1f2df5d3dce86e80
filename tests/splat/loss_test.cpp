// The photometric loss: its value against a plain double reference, its gradient against finite
// differences, and the images that make SSIM's variances degenerate.
#include "splat/train/loss/loss.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "splat/base/rng.h"

namespace cosplat {
namespace {

Buffer<float> RandomPlanar(int width, int height, uint64_t seed) {
  Rng rng{seed};
  Buffer<float> image(3 * size_t(width) * height);
  for (float& v : image) v = rng.Uniform();
  return image;
}

Image8 RandomTarget(int width, int height, int channels, uint64_t seed) {
  Rng rng{seed};
  Image8 image(width, height, channels);
  for (uint8_t& b : image.data) b = uint8_t(256 * rng.Uniform());
  return image;
}

constexpr std::array<float, 3> kBackground{0.2f, 0.5f, 0.9f};
Buffer<float> Planar(const Image8& target) {
  Buffer<float> planar;
  CompositeTarget(target, kBackground, planar);
  return planar;
}

// Wang et al. 2004 as 3DGS uses it, pixel by pixel: 11 x 11 Gaussian of sigma 1.5, zero outside.
double ReferenceSsim(int width, int height, const float* x, const float* y) {
  double window[11], norm = 0;
  for (int k = 0; k < 11; ++k) norm += window[k] = std::exp(-(k - 5) * (k - 5) / 4.5);
  double total = 0;
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col) {
      double mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
      for (int j = std::max(0, row - 5); j <= std::min(height - 1, row + 5); ++j)
        for (int i = std::max(0, col - 5); i <= std::min(width - 1, col + 5); ++i) {
          const double w = window[j - row + 5] * window[i - col + 5] / (norm * norm);
          const double a = x[j * width + i], b = y[j * width + i];
          mx += w * a, my += w * b, xx += w * a * a, yy += w * b * b, xy += w * a * b;
        }
      const double c1 = 1e-4, c2 = 9e-4;
      total += (2 * mx * my + c1) * (2 * (xy - mx * my) + c2) /
               ((mx * mx + my * my + c1) * (xx - mx * mx + yy - my * my + c2));
    }
  return total / (double(width) * height);
}

double ReferenceMeanSsim(int width, int height, const Buffer<float>& x, const Buffer<float>& y) {
  const size_t plane = size_t(width) * height;
  double sum = 0;
  for (int c = 0; c < 3; ++c)
    sum += ReferenceSsim(width, height, x.data() + c * plane, y.data() + c * plane);
  return sum / 3;
}

double ReferenceLoss(const LossWeights& weights,
                     int width,
                     int height,
                     const Buffer<float>& x,
                     const Buffer<float>& y) {
  double l1 = 0, mse = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    l1 += std::abs(double(x[i]) - y[i]);
    mse += (double(x[i]) - y[i]) * (double(x[i]) - y[i]);
  }
  const double n = double(x.size());
  return weights.l1 * l1 / n + weights.mse * mse / n +
         weights.dssim * (1 - ReferenceMeanSsim(width, height, x, y));
}

TEST(Loss, SsimEqualsThePlainReference) {
  // One band and several, the last of them low or not a multiple of five rows; widths around whole
  // packs; sides smaller than the window.
  for (const auto& [width, height] :
       {std::pair{37, 33}, {16, 64}, {133, 19}, {5, 7}, {1, 1}, {1, 40}, {13, 182}, {32, 361}}) {
    const Buffer<float> x = RandomPlanar(width, height, 1);
    const Image8 target = RandomTarget(width, height, 3, 2);
    // Float sums over 121 taps: measured below 7e-7.
    EXPECT_NEAR(
        MeanSsim(x, target, kBackground), ReferenceMeanSsim(width, height, x, Planar(target)), 2e-6)
        << width << 'x' << height;
  }
}

TEST(Loss, ValueEqualsTheReference) {
  const int width = 21, height = 40;
  const Buffer<float> x = RandomPlanar(width, height, 3);
  PhotometricLoss loss;
  Buffer<float> d;
  for (const int channels : {1, 3, 4}) {
    const Image8 target = RandomTarget(width, height, channels, 4);
    const Buffer<float> y = Planar(target);
    for (const LossWeights& weights :
         {LossWeights{}, LossWeights{1, 0, 10}, LossWeights{0, 1, 0}, LossWeights{0, 0, 1}})
      EXPECT_NEAR(loss.Evaluate(weights, x, target, kBackground, d),
                  ReferenceLoss(weights, width, height, x, y),
                  2e-6);
  }
}

TEST(Loss, GradientMatchesFiniteDifferences) {
  const float h = 1e-3f;
  for (const auto& [width, height] : {std::pair{14, 37}, {4, 3}, {1, 1}, {3, 182}}) {
    Buffer<float> x = RandomPlanar(width, height, 5);
    const Image8 target = RandomTarget(width, height, 4, 6);
    const Buffer<float> y = Planar(target);
    // Away from the kink of |x - y|.
    for (size_t i = 0; i < x.size(); ++i)
      if (std::abs(x[i] - y[i]) < 3 * h) x[i] = y[i] + (y[i] > 0.5f ? -0.1f : 0.1f);
    for (const LossWeights& weights :
         {LossWeights{1, 0, 0}, LossWeights{0, 1, 0}, LossWeights{0, 0, 1}, LossWeights{}}) {
      PhotometricLoss loss;
      Buffer<float> d;
      loss.Evaluate(weights, x, target, kBackground, d);
      ASSERT_EQ(d.size(), x.size());
      for (size_t i = 0; i < x.size(); i += 1 + x.size() / 40) {
        const float value = x[i], up_at = value + h, down_at = value - h;
        x[i] = up_at;
        const double up = ReferenceLoss(weights, width, height, x, y);
        x[i] = down_at;
        const double down = ReferenceLoss(weights, width, height, x, y);
        x[i] = value;
        const double numeric = (up - down) / (double(up_at) - down_at);
        // Both sides times the number of values, so that the tolerance is relative to a term's
        // size. Second order in h: SSIM's third derivative on noise reaches 1e4.
        const double n = double(x.size());
        EXPECT_NEAR(d[i] * n, numeric * n, 3e-3 * (1 + std::abs(numeric * n)))
            << width << 'x' << height << " value " << i;
      }
    }
  }
}

// A band's rows near its edges get what a single band over the same rows gets. Measured: 5e-7.
TEST(Loss, GradientDoesNotShowTheBands) {
  const int width = 17, height = 240, shown = 170;  // two bands of 120 rows, and one of 170
  const Buffer<float> x = RandomPlanar(width, height, 12);
  const Image8 target = RandomTarget(width, height, 3, 13);
  Buffer<float> x_top(3 * width * shown), d, d_top;
  Image8 target_top(width, shown, 3);
  for (int c = 0; c < 3; ++c)
    std::copy_n(&x[c * width * height], width * shown, &x_top[c * width * shown]);
  std::copy_n(target.data.begin(), target_top.data.size(), target_top.data.begin());
  PhotometricLoss loss;
  loss.Evaluate({}, x, target, kBackground, d);
  loss.Evaluate({}, x_top, target_top, kBackground, d_top);
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < width * (shown - 10); ++i)  // above what the second image's end changes
      ASSERT_NEAR(d[c * width * height + i] * float(d.size()),
                  d_top[c * width * shown + i] * float(d_top.size()),
                  5e-6)
          << "channel " << c << " row " << i / width;
}

TEST(Loss, DegenerateImagesAreFinite) {
  PhotometricLoss loss;
  Buffer<float> d;
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {10, 10}, {40, 40}})
    for (const int x_byte : {0, 77, 255})
      for (const int y_byte : {0, 77, 255}) {
        const Buffer<float> x = Planar(Image8(width, height, 3, uint8_t(x_byte)));
        const Image8 target(width, height, 3, uint8_t(y_byte));
        const double value = loss.Evaluate({0.8f, 0.2f, 1}, x, target, kBackground, d);
        ASSERT_TRUE(std::isfinite(value));
        for (const float v : d) ASSERT_TRUE(std::isfinite(v));
        if (x_byte == y_byte) {
          EXPECT_NEAR(value, 0, 1e-6);
          EXPECT_NEAR(MeanSsim(x, target, kBackground), 1, 1e-6);
        } else {
          EXPECT_GT(value, 0.1);
        }
      }
}

TEST(Loss, IdenticalImagesAreAMinimum) {
  const Image8 target = RandomTarget(30, 35, 3, 7);
  const Buffer<float> x = Planar(target);
  PhotometricLoss loss;
  Buffer<float> d;
  EXPECT_NEAR(loss.Evaluate({}, x, target, kBackground, d), 0, 1e-6);
  // SSIM's derivative is zero there up to rounding; that of |x - y| is defined as zero.
  for (const float v : d) EXPECT_NEAR(v * float(x.size()), 0, 1e-6);
  EXPECT_EQ(Psnr(x, x), 100);
}

TEST(Loss, BitsDoNotDependOnThreads) {
  const int width = 90, height = 301;
  const Buffer<float> x = RandomPlanar(width, height, 8);
  const Image8 target = RandomTarget(width, height, 4, 9);
  double first = 0;
  Buffer<float> d_first;
  for (const int threads : {1, 2, 5}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    PhotometricLoss loss;
    Buffer<float> d;
    const double value = loss.Evaluate({0.7f, 0.2f, 0.1f}, x, target, kBackground, d);
    if (threads == 1) {
      first = value;
      d_first = d;
    }
    EXPECT_EQ(value, first);
    EXPECT_EQ(std::memcmp(d.data(), d_first.data(), d.size() * sizeof(float)), 0) << threads;
  }
}

TEST(Loss, InstructionSetsAgree) {
  const int width = 45, height = 190;
  const Buffer<float> x = RandomPlanar(width, height, 14);
  const Image8 target = RandomTarget(width, height, 4, 15);
  PhotometricLoss loss;
  Buffer<float> d_first, d;
  const double first = loss.Evaluate({0.8f, 0.2f, 1}, x, target, kBackground, d_first);
  for (const int64_t set : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(set);
    EXPECT_NEAR(loss.Evaluate({0.8f, 0.2f, 1}, x, target, kBackground, d), first, 1e-6);
    EXPECT_NEAR(MeanSsim(x, target, kBackground),
                ReferenceMeanSsim(width, height, x, Planar(target)),
                2e-6);
    // Rounding of 121 taps: measured below 2e-6.
    for (size_t i = 0; i < d.size(); ++i)
      ASSERT_NEAR(d[i] * float(d.size()), d_first[i] * float(d.size()), 1e-5)
          << hwy::TargetName(set) << " value " << i;
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Loss, AnImageAfterASmallerOneAndWithoutSsim) {
  PhotometricLoss reused, fresh;
  Buffer<float> d, d_fresh;
  for (const int side : {9, 50, 20}) {
    const Buffer<float> x = RandomPlanar(side, side, 10);
    const Image8 target = RandomTarget(side, side, 3, 11);
    for (const LossWeights& weights : {LossWeights{}, LossWeights{1, 0, 10}}) {
      EXPECT_EQ(reused.Evaluate(weights, x, target, kBackground, d),
                PhotometricLoss().Evaluate(weights, x, target, kBackground, d_fresh));
      EXPECT_EQ(d, d_fresh);
    }
  }
}

TEST(CompositeTarget, KnownPixels) {
  Buffer<float> out;
  Image8 rgba(2, 1, 4);
  rgba.data = {255, 0, 51, 255, 255, 0, 51, 102};
  CompositeTarget(rgba, {0.5f, 1, 0}, out);
  const float alpha = 0.4f;
  const std::vector<float> expected{
      1, alpha + 0.5f * (1 - alpha), 0, 1 - alpha, 0.2f, 0.2f * alpha};
  ASSERT_EQ(out.size(), 6u);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(out[i], expected[i], 1e-6) << i;

  Image8 rgb(1, 2, 3);
  rgb.data = {255, 0, 51, 0, 102, 255};
  CompositeTarget(rgb, {1, 1, 1}, out);  // no alpha: the background does not show
  const std::vector<float> planar{1, 0, 0, 0.4f, 0.2f, 1};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(out[i], planar[i], 1e-6) << i;

  Image8 grey(1, 1, 1);
  grey.data = {51};
  CompositeTarget(grey, {1, 1, 1}, out);
  for (const float v : out) EXPECT_NEAR(v, 0.2f, 1e-6);
}

TEST(Psnr, KnownValues) {
  const Buffer<float> a(300, 0.5f), b(300, 0.6f), c(300, 1.5f);
  EXPECT_NEAR(Psnr(a, b), 20, 1e-5);
  EXPECT_NEAR(Psnr(a, c), 0, 1e-9);
  EXPECT_EQ(Psnr(a, a), 100);
}

}  // namespace
}  // namespace cosplat

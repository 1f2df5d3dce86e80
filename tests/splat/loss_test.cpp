// The photometric loss: its value against a plain double reference, its gradient against finite
// differences, and the images that make SSIM's variances degenerate.
#include "splat/loss.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

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

double ReferenceLoss(const LossWeights& weights,
                     int width,
                     int height,
                     const Buffer<float>& x,
                     const Buffer<float>& y) {
  double l1 = 0, mse = 0, ssim = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    l1 += std::abs(double(x[i]) - y[i]);
    mse += (double(x[i]) - y[i]) * (double(x[i]) - y[i]);
  }
  const size_t plane = size_t(width) * height;
  for (int c = 0; c < 3; ++c)
    ssim += ReferenceSsim(width, height, x.data() + c * plane, y.data() + c * plane) / 3;
  const double n = double(x.size());
  return weights.l1 * l1 / n + weights.mse * mse / n + weights.dssim * (1 - ssim);
}

TEST(Loss, SsimEqualsThePlainReference) {
  // Heights around the 32-row bands; sides smaller than the window.
  for (const auto& [width, height] : {std::pair{37, 33}, {16, 64}, {5, 7}, {1, 1}, {1, 40}}) {
    const Buffer<float> x = RandomPlanar(width, height, 1), y = RandomPlanar(width, height, 2);
    double expected = 0;
    const size_t plane = size_t(width) * height;
    for (int c = 0; c < 3; ++c)
      expected += ReferenceSsim(width, height, x.data() + c * plane, y.data() + c * plane) / 3;
    // Float sums over 121 taps: measured below 3e-7.
    EXPECT_NEAR(MeanSsim(width, height, x, y), expected, 2e-6) << width << 'x' << height;
  }
}

TEST(Loss, ValueEqualsTheReference) {
  const int width = 21, height = 40;
  const Buffer<float> x = RandomPlanar(width, height, 3), y = RandomPlanar(width, height, 4);
  PhotometricLoss loss;
  Buffer<float> d;
  for (const LossWeights& weights :
       {LossWeights{}, LossWeights{1, 0, 10}, LossWeights{0, 1, 0}, LossWeights{0, 0, 1}})
    EXPECT_NEAR(loss.Evaluate(weights, width, height, x, y, d),
                ReferenceLoss(weights, width, height, x, y),
                2e-6);
}

TEST(Loss, GradientMatchesFiniteDifferences) {
  const float h = 1e-3f;
  for (const auto& [width, height] : {std::pair{14, 37}, {4, 3}, {1, 1}}) {
    Buffer<float> x = RandomPlanar(width, height, 5);
    Buffer<float> y = RandomPlanar(width, height, 6);
    // Away from the kink of |x - y|.
    for (size_t i = 0; i < x.size(); ++i)
      if (std::abs(x[i] - y[i]) < 3 * h) y[i] = x[i] + (x[i] > 0.5f ? -0.1f : 0.1f);
    for (const LossWeights& weights :
         {LossWeights{1, 0, 0}, LossWeights{0, 1, 0}, LossWeights{0, 0, 1}, LossWeights{}}) {
      PhotometricLoss loss;
      Buffer<float> d;
      loss.Evaluate(weights, width, height, x, y, d);
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

TEST(Loss, DegenerateImagesAreFinite) {
  PhotometricLoss loss;
  Buffer<float> d;
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {10, 10}, {40, 40}})
    for (const float x_fill : {0.0f, 0.3f, 1.0f})
      for (const float y_fill : {0.0f, 0.3f, 1.0f}) {
        const Buffer<float> x(3 * width * height, x_fill), y(3 * width * height, y_fill);
        const double value = loss.Evaluate({0.8f, 0.2f, 1}, width, height, x, y, d);
        ASSERT_TRUE(std::isfinite(value));
        for (const float v : d) ASSERT_TRUE(std::isfinite(v));
        if (x_fill == y_fill) {
          // The window's mean of 1 rounds by 6e-8, which stands beside C2 = 9e-4.
          EXPECT_NEAR(value, 0, 0.2 * 2e-4);
          EXPECT_NEAR(MeanSsim(width, height, x, y), 1, 2e-4);
        } else {
          EXPECT_GT(value, 0.1);
        }
      }
}

TEST(Loss, IdenticalImagesAreAMinimum) {
  const Buffer<float> x = RandomPlanar(30, 35, 7);
  PhotometricLoss loss;
  Buffer<float> d;
  EXPECT_NEAR(loss.Evaluate({}, 30, 35, x, x, d), 0, 1e-6);
  // SSIM's derivative is zero there up to rounding; that of |x - y| is defined as zero.
  for (const float v : d) EXPECT_NEAR(v * float(x.size()), 0, 1e-3);
  EXPECT_EQ(Psnr(x, x), 100);
}

TEST(Loss, BitsDoNotDependOnThreads) {
  const int width = 90, height = 131;
  const Buffer<float> x = RandomPlanar(width, height, 8), y = RandomPlanar(width, height, 9);
  double first = 0;
  Buffer<float> d_first;
  for (const int threads : {1, 2, 5}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    PhotometricLoss loss;
    Buffer<float> d;
    const double value = loss.Evaluate({0.7f, 0.2f, 0.1f}, width, height, x, y, d);
    if (threads == 1) {
      first = value;
      d_first = d;
    }
    EXPECT_EQ(value, first);
    EXPECT_EQ(std::memcmp(d.data(), d_first.data(), d.size() * sizeof(float)), 0) << threads;
  }
}

TEST(Loss, AnImageAfterASmallerOneAndWithoutSsim) {
  PhotometricLoss reused, fresh;
  Buffer<float> d, d_fresh;
  for (const int side : {9, 50, 20}) {
    const Buffer<float> x = RandomPlanar(side, side, 10), y = RandomPlanar(side, side, 11);
    EXPECT_EQ(reused.Evaluate({}, side, side, x, y, d),
              PhotometricLoss().Evaluate({}, side, side, x, y, d_fresh));
    EXPECT_EQ(d, d_fresh);
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

// The device's photometric loss against the CPU's.
#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/rng.h"
#include "splat/device/cuda/stream.h"
#include "splat/train/loss/loss.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"

namespace cosplat {
namespace {

class LossParity : public test::DeviceTest {};

struct Pair {
  Buffer<float> rendered;  // [3, height, width]
  Image8 target;
};

Pair RandomPair(int width, int height, int channels) {
  Pair p{Buffer<float>(3 * size_t(width) * height), Image8(width, height, channels)};
  Rng rng{uint64_t(width * 100 + height)};
  for (float& x : p.rendered) x = 0.5f + 0.3f * rng.Normal();
  for (uint8_t& b : p.target.data) b = uint8_t(rng.Below(256));
  return p;
}

void ExpectParity(const Pair& p, const LossWeights& weights) {
  SCOPED_TRACE(std::to_string(p.target.width) + "x" + std::to_string(p.target.height) + "x" +
               std::to_string(p.target.channels) + ", dssim " + std::to_string(weights.dssim));
  const std::array<float, 3> background{0.2f, 0.9f, 0.4f};
  Buffer<float> expected;
  const double value =
      PhotometricLoss().Evaluate(weights, p.rendered, p.target, background, expected);
  cuda::CudaStream stream;
  Buffer<float> rendered, d_rendered;
  Buffer<uint8_t> target;
  rendered.Upload(p.rendered.data(), p.rendered.size(), stream);
  target.Upload(p.target.data.data(), p.target.data.size(), stream);
  const auto loss = cuda::MakeCudaLoss();
  loss->Evaluate(weights,
                 rendered,
                 {p.target.width, p.target.height, p.target.channels, target.data()},
                 background,
                 d_rendered,
                 stream);
  Buffer<float> actual(d_rendered.size());
  d_rendered.Download(actual.data(), stream);
  Readback<double> actual_value(stream);
  EXPECT_NEAR(actual_value.Get(loss->value(), stream), value, 1e-6 * (1 + std::abs(value)));
  // Sums of about a hundred products of numbers near 1: a few units in the last place.
  test::ParityTolerance tolerance;
  tolerance.relative = 1e-4;
  test::ExpectSameGradients(expected, actual, tolerance, "gradient");
}

TEST_F(LossParity, ForSizesAndWeights) {
  const int sizes[][2] = {{50, 37}, {16, 16}, {1, 1}, {3, 40}, {33, 5}};
  const LossWeights weights[] = {{0.8f, 0.2f, 0}, {1, 0, 10}, {0, 1, 0}};
  for (const auto& size : sizes)
    for (const int channels : {1, 3, 4})
      for (const LossWeights& w : weights) ExpectParity(RandomPair(size[0], size[1], channels), w);
}

// Constant and equal images: variances that rounding makes negative.
TEST_F(LossParity, OnConstantImages) {
  Pair p = RandomPair(30, 20, 3);
  std::fill(p.target.data.begin(), p.target.data.end(), uint8_t(51));
  std::fill(p.rendered.begin(), p.rendered.end(), 0.7f);
  ExpectParity(p, {0.8f, 0.2f, 0});
}

}  // namespace
}  // namespace cosplat

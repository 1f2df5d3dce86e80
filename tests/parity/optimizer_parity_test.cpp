// The device's Adam against the CPU's, with what is put off for Gaussians out of sight.
#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/rng.h"
#include "splat/device/cuda/stream.h"
#include "splat/train/cuda/adam.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

class OptimizerParity : public test::DeviceTest {};

constexpr size_t kCount = 75;  // the last group is not full

// Which are drawn in a step: by groups, now and then.
Buffer<float> RadiiOf(int step) {
  Buffer<float> radii(kCount, 0.0f);
  Rng rng{uint64_t(step)};
  for (size_t g = 0; g < AdamGroupCount(kCount); ++g)
    if (rng.Below(3) == 0) radii[std::min(g * kGaussianGroup + rng.Below(16), kCount - 1)] = 2;
  return radii;
}
std::vector<uint32_t> GroupsOf(const Buffer<float>& radii) {
  std::vector<uint32_t> groups;
  for (size_t i = 0; i < radii.size(); ++i) {
    const uint32_t g = uint32_t(i / kGaussianGroup);
    if (radii[i] > 0 && (groups.empty() || groups.back() != g)) groups.push_back(g);
  }
  return groups;
}

TEST_F(OptimizerParity, OverStepsThatSeeAPart) {
  AdamSettings settings;
  settings.rate = {1e-3f, 2e-3f, 5e-3f, 5e-2f, 2.5e-3f, 1.25e-4f};
  Gaussians values = test::RandomGaussians(kCount, 2, Basis::kDcsh, 1);
  const Gaussians start = values;
  AdamState state(values);
  std::vector<float> scale(3 * kCount);
  for (size_t i = 0; i < scale.size(); ++i) scale[i] = 0.5f + 0.01f * float(i);

  const cuda::Stream stream;
  cuda::DeviceGaussians device_values, device_gradients;
  cuda::DeviceBuffer<float> device_scale, device_radii;
  device_values.Upload(values, stream.get());
  device_scale.Upload(scale.data(), scale.size(), stream.get());
  cuda::Adam adam;
  adam.Start(device_values, stream.get());
  size_t ignored = 0;
  for (int step = 0; step < 12; ++step) {
    Gaussians gradients = test::RandomGaussians(kCount, 2, Basis::kDcsh, 50 + step);
    gradients.at(kScaleLog, 5)[1] = step % 2 ? INFINITY : NAN;
    const Buffer<float> radii = RadiiOf(step);
    ignored += AdamStepAll(settings, gradients, scale, GroupsOf(radii), values, state);
    device_gradients.Upload(gradients, stream.get());
    device_radii.Upload(radii.data(), radii.size(), stream.get());
    adam.Step(settings,
              device_gradients,
              std::as_const(device_radii).view(),
              device_scale.data(),
              device_values,
              stream.get());
  }
  AdamCatchUpAll(settings, scale, values, state);
  adam.CatchUpAll(settings, device_scale.data(), device_values, stream.get());
  EXPECT_EQ(adam.IgnoredGradients(stream.get()), ignored);
  EXPECT_GT(ignored, 0u);
  Gaussians actual = start;
  device_values.Download(actual, stream.get());
  stream.Wait();
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < values.values[a].size(); ++i)
      EXPECT_NEAR(
          actual.values[a][i], values.values[a][i], 1e-6f * (1 + std::abs(values.values[a][i])))
          << a << ", " << i;
}

}  // namespace
}  // namespace cosplat

// The device's Adam against the CPU's, with what is put off for Gaussians out of sight.
#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/rng.h"
#include "splat/device/cuda/stream.h"
#include "splat/train/cuda/kernels.h"
#include "splat/train/optimize/optimizer.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

class OptimizerParity : public test::DeviceTest {
 protected:
  OptimizerParity() { cuda::ProvideTrainKernels(); }
};

constexpr size_t kCount = 75;  // the last group is not full

// Which are drawn in a step: by groups, now and then.
Buffer<float> RadiiOf(int step) {
  Buffer<float> radii(kCount, 0.0f);
  Rng rng{uint64_t(step)};
  for (size_t g = 0; g < AdamGroupCount(kCount); ++g)
    if (rng.Below(3) == 0) radii[std::min(g * kGaussianGroup + rng.Below(16), kCount - 1)] = 2;
  return radii;
}

TEST_F(OptimizerParity, OverStepsThatSeeAPart) {
  AdamSettings settings;
  settings.rate = {1e-3f, 2e-3f, 5e-3f, 5e-2f, 2.5e-3f, 1.25e-4f};
  Gaussians values = test::RandomGaussians(kCount, 2, Basis::kDcsh, 1);
  AdamState state(values);
  std::vector<float> scale(3 * kCount);
  for (size_t i = 0; i < scale.size(); ++i) scale[i] = 0.5f + 0.01f * float(i);

  cuda::CudaStream stream;
  Gaussians device_values, device_gradients;
  AdamState device_state;
  Buffer<float> device_scale, device_radii;
  device_values.Upload(values, stream);
  device_state.Upload(state, stream);
  device_scale.Upload(scale.data(), scale.size(), stream);
  stream.Wait();
  for (int step = 0; step < 12; ++step) {
    Gaussians gradients = test::RandomGaussians(kCount, 2, Basis::kDcsh, 50 + step);
    gradients.at(kScaleLog, 5)[1] = step % 2 ? INFINITY : NAN;
    const Buffer<float> radii = RadiiOf(step);
    AdamStepAll(settings, gradients, scale, radii, values, state);
    device_gradients.Upload(gradients, stream);
    device_radii.Upload(radii.data(), radii.size(), stream);
    AdamStepAll(settings,
                device_gradients,
                device_scale,
                device_radii,
                device_values,
                device_state,
                stream);
    stream.Wait();
  }
  AdamCatchUpAll(settings, scale, values, state);
  AdamCatchUpAll(settings, device_scale, device_values, device_state, stream);
  Gaussians actual;
  AdamState actual_state;
  device_values.Download(actual, stream);
  device_state.Download(actual_state, stream);
  stream.Wait();
  EXPECT_EQ(actual_state.step, state.step);
  EXPECT_EQ(actual_state.updated, state.updated);
  EXPECT_EQ(actual_state.ignored, state.ignored);
  EXPECT_GT(state.ignored[0], 0u);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < values.values[a].size(); ++i)
      EXPECT_NEAR(
          actual.values[a][i], values.values[a][i], 1e-6f * (1 + std::abs(values.values[a][i])))
          << a << ", " << i;
}

}  // namespace
}  // namespace cosplat

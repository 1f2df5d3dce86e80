// A whole training step on the device, with nothing but its parameters coming back, against the
// CPU's: draw, compare, gradients, Adam.
#include <gtest/gtest.h>

#include <cmath>

#include "splat/train/loss/loss.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/support/device_step.h"

namespace cosplat {
namespace {

using cuda::SumOrder;
using test::ParityCase;

class StepParity : public test::DeviceTest {};

constexpr int kSteps = 4;

AdamSettings Rates() {
  AdamSettings settings;
  settings.rate = {1e-3f, 2e-3f, 5e-3f, 5e-2f, 2.5e-3f, 1.25e-4f};
  // Far above rounding: where a gradient is nothing but that, so is the step.
  settings.eps.fill(1e-5f);
  return settings;
}

Image8 TargetOf(const ParityCase& c) {
  Image8 target(c.camera.width, c.camera.height, 3);
  for (size_t i = 0; i < target.data.size(); ++i)
    target.data[i] = uint8_t(128 + 90 * std::sin(0.05 * double(i)));
  return target;
}

struct Trained {
  Gaussians gaussians;
  double loss = 0;
};

Trained TrainOnCpu(const ParityCase& c) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  Trained t{c.gaussians};
  Gaussians gradients = t.gaussians.ZerosLike();
  AdamState adam(t.gaussians);
  RenderedImage image;
  PhotometricLoss loss;
  Buffer<float> d_color, screen;
  for (int step = 0; step < kSteps; ++step) {
    rasterizer->Forward(ViewOf(t.gaussians), t.gaussians.basis, c.camera, c.settings, image, *tape);
    t.loss = loss.Evaluate({}, image.color, TargetOf(c), c.settings.background, d_color);
    rasterizer->Backward(
        ViewOf(t.gaussians), image, d_color, *tape, GradientViewOf(gradients, screen));
    AdamStepAll(Rates(), gradients, {}, tape->radii(), t.gaussians, adam);
  }
  AdamCatchUpAll(Rates(), {}, t.gaussians, adam);
  return t;
}

Trained TrainOnDevice(const ParityCase& c, SumOrder order) {
  test::DeviceStep device(c.gaussians, c.camera, TargetOf(c), c.settings, Rates(), order);
  for (int step = 0; step < kSteps; ++step) device.Run();
  AdamCatchUpAll(Rates(), {}, device.gaussians, device.adam, device.stream());
  Trained t;
  device.gaussians.Download(t.gaussians, device.stream());
  t.loss = device.Loss();
  return t;
}

Buffer<float> ChangeOf(const ParityCase& c, const Trained& t, int a) {
  Buffer<float> change = t.gaussians.values[a];
  for (size_t i = 0; i < change.size(); ++i) change[i] -= c.gaussians.values[a][i];
  return change;
}

TEST_F(StepParity, OverAFewSteps) {
  const ParityCase c = test::RandomCase("step", 300, 60, 40, Basis::kDcsh, 2);
  const Trained cpu = TrainOnCpu(c);
  for (const SumOrder order : {SumOrder::kAny, SumOrder::kFixed}) {
    const Trained device = TrainOnDevice(c, order);
    EXPECT_NEAR(device.loss, cpu.loss, 1e-5);
    for (int a = 0; a <= kColorRest; ++a) {
      const test::Agreement g = test::AgreementOf(ChangeOf(c, cpu, a), ChangeOf(c, device, a));
      EXPECT_GT(g.norm, 0) << a;
      EXPECT_GE(g.cosine, 1 - 1e-5) << a;
      EXPECT_LE(g.relative, 5e-3) << a;
    }
  }
}

// An image that is never gone back from keeps nothing for it, and is the same.
TEST_F(StepParity, AImageAloneHasTheSameBits) {
  const ParityCase c = test::RandomCase("image", 300, 60, 40, Basis::kDcsh, 2);
  cuda::CudaRasterizer rasterizer(SumOrder::kAny);
  Stream& stream = rasterizer.stream();
  Gaussians gaussians;
  gaussians.Upload(c.gaussians, stream);
  std::vector<float> images[2];
  for (const bool keep : {true, false}) {
    cuda::CudaTape tape(keep, SumOrder::kAny);
    RenderedImage image;
    rasterizer.Forward(ViewOf(gaussians), gaussians.basis, c.camera, c.settings, image, tape);
    images[keep].resize(image.color.size());
    image.color.Download(images[keep].data(), stream);
    stream.Wait();
    EXPECT_EQ(tape.checkpoints.empty(), !keep);
  }
  EXPECT_EQ(images[0], images[1]);
}

}  // namespace
}  // namespace cosplat

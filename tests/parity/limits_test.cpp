// Counts that only a device gets to in a test's time.
#include <gtest/gtest.h>

#include "splat/render/cuda/rasterizer.h"
#include "splat/render/rasterizer.h"
#include "tests/parity/compare.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/parity_case.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

class DeviceLimits : public test::DeviceTest {};

std::unique_ptr<Rasterizer> OnDevice() {
  return MakeCopyingRasterizer(std::make_unique<cuda::CudaRasterizer>(cuda::SumOrder::kAny));
}

// 2^32 pairs and a few more, whose lowest 32 bits are a few: refused before they are stored.
TEST_F(DeviceLimits, TooManyInstancesAreRefused) {
  constexpr size_t kCount = 1025;
  constexpr int kSide = 2048 * kTileSize;  // 2^22 tiles
  test::ParityCase c = test::RandomCase("everywhere", kCount, 64, 64, Basis::kDcsh, 0);
  c.camera = c.camera.Resized(kSide, kSide);
  for (size_t i = 0; i < kCount; ++i) {
    for (int k = 0; k < 3; ++k) c.gaussians.at(kScaleLog, i)[k] = 6;
    *c.gaussians.at(kOpacityLogit, i) = 5;
  }
  const auto device = OnDevice();
  const auto tape = device->MakeTape();
  RenderedImage image;
  test::ExpectError(
      [&] { device->Forward(ViewOf(c), c.gaussians.basis, c.camera, c.settings, image, *tape); },
      {"splat-tile pairs", "2^31"});
}

// Many blocks, many passes of every sort: against the CPU.
TEST_F(DeviceLimits, AMillionGaussiansAgree) {
  test::ParityCase c = test::RandomCase("many", 1000000, 1024, 768, Basis::kDcsh, 1);
  for (size_t i = 0; i < c.gaussians.size(); ++i)
    for (int k = 0; k < 3; ++k) c.gaussians.at(kScaleLog, i)[k] -= 3;
  const std::unique_ptr<Rasterizer> cpu = MakeCpuRasterizer(), device = OnDevice();
  RenderedImage images[2];
  size_t instances[2], k = 0;
  for (Rasterizer* r : {cpu.get(), device.get()}) {
    const auto tape = r->MakeTape();
    r->Forward(ViewOf(c), c.gaussians.basis, c.camera, c.settings, images[k], *tape);
    instances[k++] = tape->counts()->instances;
  }
  EXPECT_NEAR(double(instances[1]), double(instances[0]), 1e-4 * double(instances[0]));
  ExpectSameImage(images[0].color, images[1].color, c.tolerance, "colour");
}

}  // namespace
}  // namespace cosplat

// The choice of a back end by name.
#include "splat/render/device.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

TEST(Device, IsChosenByName) {
  setenv("CUDA_VISIBLE_DEVICES", "-1", 1);  // no GPU, whatever the machine has
  EXPECT_EQ(DeviceFromString("cpu"), Device::kCpu);
  EXPECT_EQ(DeviceFromString("auto"), Device::kCpu);
  test::ExpectError([] { DeviceFromString("cuda"); }, {"--device", "cuda"});
  test::ExpectError([] { DeviceFromString("gpu", "--on"); }, {"--on", "gpu"});
  test::ExpectError([] { DeviceFromString(""); }, {"--device"});
}

TEST(Device, TheCpuIsAlwaysThere) { EXPECT_NE(MakeRasterizer(Device::kCpu), nullptr); }

}  // namespace
}  // namespace cosplat

// The choice of a back end.
#include "splat/render/device.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

TEST(Device, IsTheOneThatIsWantedOrThere) {
  setenv("CUDA_VISIBLE_DEVICES", "-1", 1);  // no GPU, whatever the machine has
  EXPECT_EQ(UsableDevice(Device::kCpu), Device::kCpu);
  EXPECT_EQ(UsableDevice({}), Device::kCpu);
  test::ExpectError([] { UsableDevice(Device::kCuda); }, {"--device", "cuda"});
  test::ExpectError([] { UsableDevice(Device::kCuda, "--on"); }, {"--on", "cuda"});
}

TEST(Device, TheCpuIsAlwaysThere) { EXPECT_NE(MakeRasterizer(Device::kCpu), nullptr); }

}  // namespace
}  // namespace cosplat

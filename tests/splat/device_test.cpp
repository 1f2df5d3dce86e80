// The choice of a back end, and its memory.
#include "splat/render/device.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <type_traits>
#include <vector>

#include "splat/device/buffer.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

TEST(Buffer, IsCopiedFromAVectorOnlyWhereItSaysSo) {
  EXPECT_FALSE((std::is_convertible_v<std::vector<float>, Buffer<float>>));
  EXPECT_FALSE((std::is_convertible_v<Buffer<float>, std::vector<float>>));
  EXPECT_EQ(Buffer<float>(std::vector<float>{1, 2}), (Buffer<float>{1, 2}));
}

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

// Tests that need a device: skipped, and said so, where there is none. Where one is promised
// (COSPLAT_REQUIRE_DEVICE is set: tests/gpu/run.sh) its absence is a failure.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

#include "splat/device/cuda/device.h"

namespace cosplat::test {

class DeviceTest : public testing::Test {
 protected:
  void SetUp() override {
    if (cuda::FindDevice()) return;
    if (std::getenv("COSPLAT_REQUIRE_DEVICE")) FAIL() << "no CUDA device, and one was promised";
    GTEST_SKIP() << "no CUDA device";
  }
};

}  // namespace cosplat::test

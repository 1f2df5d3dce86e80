// The GPU in use: the first that CUDA lists (select it by CUDA_VISIBLE_DEVICES), or, of several
// processes that train together, one each.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace cosplat::cuda {

struct DeviceInfo {
  std::string name;
  int major = 0, minor = 0;  // compute capability
  int multiprocessors = 0;
  size_t memory = 0;  // bytes
};

// std::nullopt if there is no GPU or no driver.
std::optional<DeviceInfo> FindDevice();

size_t DeviceCount();
// From now on this thread uses GPU number `index`, counted in a circle.
void UseDevice(size_t index);

// Why FindDevice finds none: no GPU, no driver, a driver older than this program's CUDA runtime, or
// another error of the runtime. Empty if it finds one.
std::string WhyNoDevice();

}  // namespace cosplat::cuda

// The GPU that work is given to: the first that CUDA lists (CUDA_VISIBLE_DEVICES chooses).
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

// None where there is no GPU or no driver.
std::optional<DeviceInfo> FindDevice();

}  // namespace cosplat::cuda

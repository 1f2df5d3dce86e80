#include "splat/device/cuda/device.h"

#include "splat/device/cuda/check.h"

namespace cosplat::cuda {

std::optional<DeviceInfo> FindDevice() {
  int count = 0;
  if (cudaGetDeviceCount(&count) != cudaSuccess || count == 0) {
    cudaGetLastError();  // no driver is no error of whoever asks
    return std::nullopt;
  }
  cudaDeviceProp p{};
  Check(cudaGetDeviceProperties(&p, 0), "cudaGetDeviceProperties");
  return DeviceInfo{p.name, p.major, p.minor, p.multiProcessorCount, p.totalGlobalMem};
}

}  // namespace cosplat::cuda

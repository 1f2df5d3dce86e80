#include "splat/train/train_device.h"

#include "splat/base/error.h"
#include "splat/train/host_step_engine.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/device/cuda/device.h"
#include "splat/train/cuda/device_step_engine.h"
#endif

namespace cosplat {

StepEngineMaker StepEngineOn(Device device, bool deterministic) {
  if (device == Device::kCpu) return MakeHostStepEngine;
#if defined(COSPLAT_HAS_CUDA)
  return cuda::MakeDeviceStepEngine(deterministic ? cuda::SumOrder::kFixed : cuda::SumOrder::kAny);
#else
  (void)deterministic;
  throw Error("device", "this program was built without CUDA");
#endif
}

std::string NameOf(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  const auto gpu = device == Device::kCuda ? cuda::FindDevice() : std::nullopt;
  if (gpu) return gpu->name;
#endif
  return device == Device::kCpu ? "CPU" : "CUDA";
}

}  // namespace cosplat

#include "splat/train/train_device.h"

#include "splat/base/error.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/device/cuda/device.h"
#include "splat/train/cuda/kernels.h"
#include "splat/train/cuda/loss.h"
#endif

namespace cosplat {

StepEngineMaker StepEngineOn(Device device, bool deterministic, const InstanceForecast& forecast) {
  if (device == Device::kCpu) return MakeHostStepEngine;
#if defined(COSPLAT_HAS_CUDA)
  cuda::ProvideTrainKernels();
  return [=](const TrainSettings& settings, Subject& subject, TrainingState& state) {
    StepDevice parts{MakeRasterizerOn(device, deterministic), cuda::MakeCudaLoss()};
    return std::make_unique<StepEngine>(settings, subject, state, std::move(parts), forecast);
  };
#else
  (void)deterministic;
  (void)forecast;
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

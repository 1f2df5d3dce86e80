#include "splat/base/error.h"
#include "splat/train/step/step_engine.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/device/cuda/device.h"
#include "splat/train/cuda/kernels.h"
#endif

namespace cosplat {

StepEngineMaker StepEngineOn(Device device,
                             bool deterministic,
                             const InstanceForecast& forecast,
                             std::shared_ptr<Ranks> ranks) {
  if (device == Device::kCpu) return HostStepEngineOn(ranks);
#if defined(COSPLAT_HAS_CUDA)
  cuda::ProvideTrainKernels();
  double memory_share = 1;
  if (ranks->size() > 1) {
    const size_t devices = cuda::DeviceCount();
    cuda::UseDevice(ranks->local_rank());
    memory_share /= double((ranks->local_size() + devices - 1) / devices);
  }
  return [=](const TrainSettings& settings, Subject& subject, TrainingState& state) {
    const bool fixed_order = deterministic || settings.batch > 1;
    StepDevice parts{
        MakeRasterizerOn(device, fixed_order), cuda::MakeCudaLoss(), ranks, memory_share};
    return std::make_unique<StepEngine>(settings, subject, state, std::move(parts), forecast);
  };
#else
  (void)deterministic;
  (void)forecast;
  throw Error("device", "this program was built without CUDA");
#endif
}

}  // namespace cosplat

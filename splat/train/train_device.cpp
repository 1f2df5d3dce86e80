#include "splat/base/error.h"
#include "splat/train/step_engine.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/device/cuda/device.h"
#include "splat/train/cuda/step.h"
#endif

namespace cosplat {

StepEngineMaker StepEngineOn(Device device,
                             bool deterministic,
                             const InstanceForecast& forecast,
                             std::shared_ptr<Ranks> ranks) {
  if (device == Device::kCpu) return HostStepEngineOn(ranks);
#if defined(COSPLAT_HAS_CUDA)
  cuda::ProvideTrainKernels();
  const bool several = ranks->size() > 1;
  if (several) cuda::UseDevice(ranks->local_rank());
  return [=](const TrainSettings& settings, Subject& subject, TrainingState& state) {
    StepDevice parts{
        MakeRasterizerOn(device, deterministic || several), cuda::MakeCudaLoss(), ranks};
    return std::make_unique<StepEngine>(settings, subject, state, std::move(parts), forecast);
  };
#else
  (void)deterministic;
  (void)forecast;
  throw Error("device", "this program was built without CUDA");
#endif
}

}  // namespace cosplat

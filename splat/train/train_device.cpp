#include "splat/base/error.h"
#include "splat/train/step_engine.h"

#if defined(COSPLAT_HAS_CUDA)
#include "splat/train/cuda/step.h"
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

}  // namespace cosplat

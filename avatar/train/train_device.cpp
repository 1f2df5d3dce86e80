#include "avatar/train/avatar_subject.h"
#include "splat/train/step/step_engine.h"

#if defined(COSPLAT_HAS_CUDA)
#include "avatar/surface/cuda/kernels.h"
#endif

namespace cosplat {

StepEngineMaker AvatarEngineOn(Device device, bool deterministic) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) cuda::ProvideAvatarKernels();
#endif
  return StepEngineOn(device, deterministic);
}

}  // namespace cosplat

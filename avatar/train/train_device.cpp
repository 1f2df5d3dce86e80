#include "avatar/train/train_device.h"

#include "splat/train/train_device.h"

#if defined(COSPLAT_HAS_CUDA)
#include "avatar/surface/cuda/kernels.h"
#endif

namespace cosplat {

StepEngineMaker AvatarEngineOn(Device device, bool deterministic) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) cuda::ProvideSurfaceKernels();
#endif
  return StepEngineOn(device, deterministic);
}

}  // namespace cosplat

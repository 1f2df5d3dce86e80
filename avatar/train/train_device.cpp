#include "avatar/train/train_device.h"

#include "splat/train/host_step_engine.h"

#if defined(COSPLAT_HAS_CUDA)
#include "avatar/train/cuda/device_avatar.h"
#endif

namespace cosplat {

StepEngineMaker AvatarEngineOn(Device device, bool deterministic, AvatarSubject& subject) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda)
    return cuda::MakeDeviceAvatarEngine(
        deterministic ? cuda::SumOrder::kFixed : cuda::SumOrder::kAny, subject);
#else
  (void)device;  // DeviceFromString gives no other
  (void)deterministic;
  (void)subject;
#endif
  return MakeHostStepEngine;
}

}  // namespace cosplat

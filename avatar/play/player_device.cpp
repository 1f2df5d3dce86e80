#include "avatar/play/player_device.h"

#if defined(COSPLAT_HAS_CUDA)
#include "avatar/play/cuda/device_avatar_renderer.h"
#endif

namespace cosplat {

AvatarRendererMaker AvatarRendererOn(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) return cuda::MakeDeviceRenderers();
#else
  (void)device;  // DeviceFromString gives no other
#endif
  return {};
}

}  // namespace cosplat

#include "avatar/play/player_device.h"

#if defined(COSPLAT_HAS_CUDA)
#include "avatar/play/cuda/device_drawer.h"
#endif

namespace cosplat {

AvatarDrawerMaker DrawerOn(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) return cuda::MakeDeviceDrawers();
#else
  (void)device;  // DeviceFromString gives no other
#endif
  return {};
}

}  // namespace cosplat

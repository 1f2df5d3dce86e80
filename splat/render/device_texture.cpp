#include "splat/render/device_texture.h"

namespace cosplat {

DeviceTextureMaker DeviceTextureOn(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) return cuda::MakeGlTexture;
#else
  (void)device;  // DeviceFromString gives no other
#endif
  return {};
}

}  // namespace cosplat

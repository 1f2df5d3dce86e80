#include "splat/render/device_texture.h"

namespace cosplat {

DeviceTextureMaker DeviceTextureOn(Device device) {
#if defined(COSPLAT_HAS_CUDA)
  if (device == Device::kCuda) return cuda::MakeGlTexture;
#else
  (void)device;  // without CUDA, UsableDevice returns only kCpu
#endif
  return {};
}

}  // namespace cosplat

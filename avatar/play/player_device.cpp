#include "avatar/play/avatar_renderer.h"

#if defined(COSPLAT_HAS_CUDA)
#include "avatar/surface/cuda/kernels.h"
#endif

namespace cosplat {

AvatarRendererMaker AvatarRendererOn(Device device) {
  if (device == Device::kCpu) return {};
#if defined(COSPLAT_HAS_CUDA)
  cuda::ProvideAvatarKernels();
#endif
  return [device, store = std::make_shared<DirectionStore>()](const AvatarModel& avatar,
                                                              const AvatarPosing& posing) {
    return std::make_unique<AvatarRenderer>(
        MakeRasterizerOn(device, false), avatar, posing, *store);
  };
}

}  // namespace cosplat

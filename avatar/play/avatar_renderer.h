// Who draws an avatar for a Player, where that is not the CPU: the seam that avatar/*/cuda/ is
// behind.
//
// Player: parameters -> FlameRig (joints posed, on the CPU) -> AvatarRenderer: vertices, surface,
// binding, rasteriser -> picture. avatar/play/player_device.h chooses.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "avatar/model/avatar_model.h"
#include "flame/posing.h"
#include "splat/device/buffer.h"
#include "splat/render/alpha_mode.h"
#include "splat/render/device_picture.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// What an avatar's vertices are posed from: FLAME's head, then the bust, which keeps still.
struct AvatarPosing {
  PosingArrays<float> flame;
  View<const float> bust;  // [K, 3] metres, posed
};

class AvatarRenderer {
 public:
  virtual ~AvatarRenderer() = default;
  // As Rasterizer::Forward, of the avatar in this pose, within float's range (PosingReach).
  // `placement` is another one where the pose is; 0 is none.
  virtual void Draw(const FlameRig<float>& rig,
                    uint64_t placement,
                    const Camera& camera,
                    const RenderSettings& settings,
                    RenderedImage& image) = 0;
  // The same, but the picture stays on the device; made where `out` is null, otherwise `out` is of
  // this renderer. The background must be black but with AlphaMode::kOpaque.
  virtual void DrawToStay(const FlameRig<float>& rig,
                          uint64_t placement,
                          const Camera& camera,
                          const RenderSettings& settings,
                          AlphaMode alpha,
                          std::unique_ptr<DevicePicture>& out) = 0;

  PhaseTimes times;  // project, sort, blend; the caller resets it
};

// Of one avatar, whose arrays fit each other (CheckEmbedding) and which need not outlive the call;
// of its posing FLAME's directions do, at the same place: renderers of one maker may share what
// they make of them.
using AvatarRendererMaker =
    std::function<std::unique_ptr<AvatarRenderer>(const AvatarModel&, const AvatarPosing&)>;

}  // namespace cosplat

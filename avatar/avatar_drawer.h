// Who draws an avatar for a Player, where that is not the CPU: the seam that avatar/cuda/ is
// behind.
//
// Player: parameters -> posed vertices (on the CPU) -> AvatarDrawer: surface, binding, rasteriser
// -> picture. avatar/player_device.h chooses.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "avatar/avatar_model.h"
#include "splat/rasterizer.h"

namespace cosplat {

class AvatarDrawer {
 public:
  virtual ~AvatarDrawer() = default;
  // As Rasterizer::Forward, of the avatar on these vertices: [V, 3] metres, finite. `placement` is
  // another one where they are others; 0 is none.
  virtual void Draw(const std::vector<float>& vertices,
                    uint64_t placement,
                    const Camera& camera,
                    const RenderSettings& settings,
                    RenderedImage& image) = 0;

  PhaseTimes times;  // project, sort, blend; the caller resets it
};

// Of one avatar, whose arrays fit each other (CheckEmbedding) and which need not outlive the call.
using AvatarDrawerMaker = std::function<std::unique_ptr<AvatarDrawer>(const AvatarModel&)>;

}  // namespace cosplat

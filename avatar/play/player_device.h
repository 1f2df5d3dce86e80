// Who draws on a device for a Player.
#pragma once

#include "avatar/play/avatar_renderer.h"
#include "splat/render/device.h"

namespace cosplat {

// For PlayerSettings; empty for the CPU. Players of the same FlameModel that get copies of one
// share the model's directions there. Making a renderer throws Error for an avatar with the
// released rule (avatar/surface/released_binding.h), which is the CPU's to draw.
AvatarRendererMaker AvatarRendererOn(Device device);

}  // namespace cosplat

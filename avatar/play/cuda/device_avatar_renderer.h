// Draws an avatar on the device: avatar/play/avatar_renderer.h there.
//
// posed vertices (60 kB a frame) -> DeviceSurface -> DeviceBinding -> PictureRenderer -> picture in
// the host's memory (16 bytes per pixel), or one that stays. Everything else stays on the device.
#pragma once

#include "avatar/play/avatar_renderer.h"

namespace cosplat::cuda {

// Copies of it share the directions of a FLAME model. Making a renderer throws Error where the
// avatar has the released rule, or the device has no room.
AvatarRendererMaker MakeDeviceRenderers();

}  // namespace cosplat::cuda

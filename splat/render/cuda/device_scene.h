// splat/render/scene_drawer.h on a CUDA device.
#pragma once

#include "splat/render/scene_drawer.h"

namespace cosplat::cuda {

// Throws Error where the device has no room.
std::unique_ptr<SceneDrawer> MakeDeviceScene(const Gaussians& scene);

}  // namespace cosplat::cuda

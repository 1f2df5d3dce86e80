// splat/render/scene_renderer.h on a CUDA device.
#pragma once

#include "splat/render/scene_renderer.h"

namespace cosplat::cuda {

// Throws Error where the device has no room.
std::unique_ptr<SceneRenderer> MakeDeviceScene(const Gaussians& scene);

}  // namespace cosplat::cuda

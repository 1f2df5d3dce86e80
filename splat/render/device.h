// Which back end draws: the choice behind `--device auto|cpu|cuda`.
#pragma once

#include <memory>
#include <string>

#include "splat/render/rasterizer.h"
#include "splat/render/scene_renderer.h"

namespace cosplat {

enum class Device { kCpu, kCuda };

// "cpu"; "cuda", an Error naming `field` and the reason where this program or this machine has
// none; "auto", which is CUDA where both have it.
Device DeviceFromString(const std::string& name, const std::string& field = "--device");

// For people: "CPU", or the GPU's name.
std::string NameOf(Device device);

// Of arrays in the device's memory. deterministic: gradients are added in a fixed order, as on the
// CPU they always are.
std::unique_ptr<Rasterizer> MakeRasterizerOn(Device device, bool deterministic);

// Of arrays in the host's memory, for single images: for a device everything is copied with each
// call. Deterministic.
std::unique_ptr<Rasterizer> MakeRasterizer(Device device);

// For many images of one scene; empty for the CPU, which draws by a Rasterizer.
SceneRendererMaker SceneRendererOn(Device device);

}  // namespace cosplat

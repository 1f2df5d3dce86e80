// Selection of the back end that renders: `--device auto|cpu|cuda`.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "splat/render/rasterizer.h"
#include "splat/render/scene_renderer.h"

namespace cosplat {

enum class Device { kCpu, kCuda };

// The device that is wanted or, of none, CUDA if both this program and this machine support it.
// Throws Error naming `field` and the reason for CUDA without support.
Device UsableDevice(std::optional<Device> wanted, const std::string& field = "--device");

// Display name: "CPU", or the GPU's name.
std::string NameOf(Device device);

// Rasteriser of arrays in the device's memory. deterministic: gradients are summed in a fixed
// order, as they always are on the CPU.
std::unique_ptr<StagedRasterizer> MakeRasterizerOn(Device device, bool deterministic);

// Rasteriser of arrays in host memory, for single images: with a CUDA device, every call copies
// everything. Deterministic.
std::unique_ptr<Rasterizer> MakeRasterizer(Device device);

// For many images of one scene; empty for the CPU, which renders with a Rasterizer.
SceneRendererMaker SceneRendererOn(Device device);

}  // namespace cosplat

// A rasteriser of arrays in the host's memory by one of a device.
#pragma once

#include <memory>

#include "splat/render/rasterizer.h"

namespace cosplat {

// For single pictures: everything is copied there and back with each call.
std::unique_ptr<Rasterizer> MakeCopyingRasterizer(std::unique_ptr<Rasterizer> on_device);

}  // namespace cosplat

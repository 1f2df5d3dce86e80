// The device behind the interface that everything else draws by (splat/render/rasterizer.h).
#pragma once

#include <memory>

#include "splat/render/cuda/blend_backward.h"
#include "splat/render/rasterizer.h"

namespace cosplat::cuda {

// Takes Gaussians from the host's memory and brings pictures and gradients back to it with each
// call: for single pictures and for tests. What stays on the device is cuda::Renderer's.
std::unique_ptr<Rasterizer> MakeCudaRasterizer(SumOrder order);

}  // namespace cosplat::cuda

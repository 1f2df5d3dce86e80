#pragma once

#include <memory>

#include "splat/train/loss.h"

namespace cosplat::cuda {

// rendered image, target image's bytes -> SSIM's partials -> dL/d(rendered), in two passes of 16x16
// pixels a block; sums are added in a fixed order.
std::unique_ptr<StepLoss> MakeCudaLoss();

}  // namespace cosplat::cuda

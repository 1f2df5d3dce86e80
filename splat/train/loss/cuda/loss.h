// The loss of a training step on a CUDA device.
#pragma once

#include <memory>

#include "splat/train/loss/loss.h"

namespace cosplat::cuda {

// rendered image, bytes of the target image -> SSIM partials -> dL/d(rendered), in two passes with
// 16x16 pixels per block; sums are computed in a fixed order.
std::unique_ptr<StepLoss> MakeCudaLoss();

}  // namespace cosplat::cuda

// What a training step on a CUDA device needs besides the rasteriser: its kernels and its loss.
#pragma once

#include <memory>

#include "splat/train/loss.h"

namespace cosplat::cuda {

// Registers the kernels of splat/train/kernels/, so that they run on a device.
void ProvideTrainKernels();

// rendered image, bytes of the target image -> SSIM partials -> dL/d(rendered), in two passes with
// 16x16 pixels per block; sums are computed in a fixed order.
std::unique_ptr<StepLoss> MakeCudaLoss();

}  // namespace cosplat::cuda

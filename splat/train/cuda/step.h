// What a training step on a CUDA device needs beside the rasteriser: its kernels and its loss.
#pragma once

#include <memory>

#include "splat/train/loss.h"

namespace cosplat::cuda {

// Lets devices run the kernels of splat/train/kernels/.
void ProvideTrainKernels();

// rendered image, target image's bytes -> SSIM's partials -> dL/d(rendered), in two passes of 16x16
// pixels a block; sums are added in a fixed order.
std::unique_ptr<StepLoss> MakeCudaLoss();

}  // namespace cosplat::cuda

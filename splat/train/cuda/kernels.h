// The kernels of training on a CUDA device.
#pragma once

namespace cosplat::cuda {

// Registers the kernels of splat/train/*/kernels/, so that they run on a device.
void ProvideTrainKernels();

}  // namespace cosplat::cuda

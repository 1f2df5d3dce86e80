#pragma once

namespace cosplat::cuda {

// Lets devices run the kernels of splat/train/kernels/.
void ProvideTrainKernels();

}  // namespace cosplat::cuda

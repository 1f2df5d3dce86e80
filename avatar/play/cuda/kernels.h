#pragma once

namespace cosplat::cuda {

// Lets devices run the kernels of flame/kernels/.
void ProvidePosingKernels();

}  // namespace cosplat::cuda

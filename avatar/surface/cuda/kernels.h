#pragma once

namespace cosplat::cuda {

// Lets devices run the kernels of avatar/surface/kernels/.
void ProvideSurfaceKernels();

}  // namespace cosplat::cuda

#pragma once

namespace cosplat::cuda {

// Lets devices run the kernels of splat/render/kernels/ that ForEach launches.
void ProvideRenderKernels();

}  // namespace cosplat::cuda

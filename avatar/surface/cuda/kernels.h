#pragma once

namespace cosplat::cuda {

// Registers the kernels of flame/kernels/ and avatar/surface/kernels/, which pose the mesh and the
// Gaussians embedded on it, for CUDA devices.
void ProvideAvatarKernels();

}  // namespace cosplat::cuda

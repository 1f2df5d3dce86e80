#pragma once

namespace cosplat::cuda {

// Lets devices run the kernels of flame/kernels/ and avatar/surface/kernels/: they pose the mesh
// and what is embedded in it.
void ProvideAvatarKernels();

}  // namespace cosplat::cuda

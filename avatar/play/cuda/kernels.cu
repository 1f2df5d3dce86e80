#include "avatar/play/cuda/kernels.h"
#include "flame/kernels/pose.h"
#include "splat/device/cuda/kernels.cuh"

namespace cosplat::cuda {

void ProvidePosingKernels() {
  Provide<flame_math::BlendShapesKernel<float>, flame_math::SkinKernel<float>>();
}

}  // namespace cosplat::cuda

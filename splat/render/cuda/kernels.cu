#include "splat/device/cuda/kernels.cuh"
#include "splat/render/cuda/kernels.h"
#include "splat/render/kernels/pixel_bytes.h"

namespace cosplat::cuda {

void ProvideRenderKernels() {
  Provide<WritePixel<AlphaMode::kStraight>,
          WritePixel<AlphaMode::kPremultiplied>,
          WritePixel<AlphaMode::kOpaque>>();
}

}  // namespace cosplat::cuda

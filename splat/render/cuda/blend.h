// A tile's instances, front to back -> image, and back: a block per tile, or a warp per bucket.
#pragma once

#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {

// Draws tape.lists into the image; with tape.kept also what BlendBackward needs.
void BlendForward(CudaTape& tape, RenderedImage& image, Stream& stream);

// Fills tape.d_splats, 0 where nothing was drawn. d_color: [3, height, width] on the device.
void BlendBackward(CudaTape& tape,
                   const RenderedImage& image,
                   const float* d_color,
                   Stream& stream);

// contributions: [count] on the device, overwritten. In a fixed order.
void SumContributions(CudaTape& tape,
                      const RenderedImage& image,
                      Contribution* contributions,
                      Stream& stream);

}  // namespace cosplat::cuda

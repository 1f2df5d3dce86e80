// Tiles, front to back -> image: a block per tile, a thread per pixel.
#pragma once

#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {

// Draws tape.lists into the image; with tape.kept also what Backward needs.
void BlendForward(Tape& tape, DeviceImage& image, cudaStream_t stream);

}  // namespace cosplat::cuda

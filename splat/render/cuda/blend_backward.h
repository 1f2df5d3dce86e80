// dL/d(image) -> gradients of the projected splats, per Gaussian over buckets (bucket_walk.cuh).
#pragma once

#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {

// How a Gaussian's parts from its tiles are added up: as they come, by atomics, so that the last
// bits differ from run to run; or in a fixed order, by way of a record for each instance.
enum class SumOrder { kAny, kFixed };

// Fills tape.d_splats, 0 where nothing was drawn. d_color: [3, height, width] on the device.
void BlendBackward(Tape& tape,
                   const DeviceImage& image,
                   const float* d_color,
                   SumOrder order,
                   cudaStream_t stream);

// contributions: [count] on the device, overwritten. In a fixed order.
void SumContributions(Tape& tape,
                      const DeviceImage& image,
                      Contribution* contributions,
                      cudaStream_t stream);

}  // namespace cosplat::cuda

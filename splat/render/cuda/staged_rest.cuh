// Colour coefficients of bands 1 and above, and their gradients, by way of shared memory.
//
// A thread reads all coefficients of its Gaussian, [N, rest_width] in memory, so that lanes would
// read numbers that are rest_width apart, each from a line of its own. A warp therefore copies
// those of its 32 Gaussians, which are neighbours, in one piece.
#pragma once

#include "splat/device/cuda/launch.cuh"
#include "splat/math/scalar.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat::cuda {

constexpr unsigned kStagedThreads = 128;  // of a block
static_assert(kWarp % kGaussianGroup == 0);

struct StagedRest {
  float* shared;        // [kWarp, width] the warp's own
  int width;            // of a row
  size_t first, count;  // the warp's first Gaussian; of all

  // Like an array of all Gaussians, but only the warp's own rows exist.
  __device__ float* rows() const { return shared - first * width; }
  // groups: bit l is set if the group of lane l is to be copied. All lanes must call these.
  __device__ void Load(const float* all, unsigned groups) const { Copy(all, rows(), groups); }
  __device__ void Store(float* all, unsigned groups) const { Copy(rows(), all, groups); }

 private:
  __device__ void Copy(const float* from, float* to, unsigned groups) const {
    __syncwarp();
    for (size_t l = 0; l < kWarp; l += kGaussianGroup) {
      if ((groups >> l & 1) == 0) continue;
      const size_t end = math::Min(first + l + kGaussianGroup, count) * width;
      for (size_t k = (first + l) * width + Lane(); k < end; k += kWarp) to[k] = from[k];
    }
    __syncwarp();
  }
};

}  // namespace cosplat::cuda

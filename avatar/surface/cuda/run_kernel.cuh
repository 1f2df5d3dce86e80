// The kernels of avatar/surface/kernels/ launched with a thread per element.
#pragma once

#include "splat/device/cuda/launch.cuh"
#include "splat/render/kernels/rows.h"

namespace cosplat::cuda {

// A kernel whose scalar is free: an element is a row.
template <class Kernel>
struct AtRow {
  Kernel kernel;
  __device__ void operator()(size_t i) const { kernel.template Run<float>(math::Rows{i, 1}); }
};
template <class Kernel>
void ForEachRow(size_t n, cudaStream_t stream, const Kernel& kernel) {
  ForEach(n, stream, AtRow<Kernel>{kernel});
}

// A kernel of plain floats.
template <class Kernel>
struct AtIndex {
  Kernel kernel;
  __device__ void operator()(size_t i) const { kernel.Run(i); }
};
template <class Kernel>
void ForEachIndex(size_t n, cudaStream_t stream, const Kernel& kernel) {
  ForEach(n, stream, AtIndex<Kernel>{kernel});
}

}  // namespace cosplat::cuda

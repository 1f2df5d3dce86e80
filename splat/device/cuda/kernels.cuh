// Registers the kernels (splat/device/for_each.h) that are compiled for CUDA devices: each
// library's cuda/kernels.cu calls these functions once for its own.
#pragma once

#include "splat/device/cuda/launch.cuh"
#include "splat/device/for_each.h"
#include "splat/math/rows.h"

namespace cosplat::cuda {

// Registers kernels for ForEach.
template <class... Kernels>
void Provide() {
  ((KernelLaunch<Kernels>::function = &ForEachThread<Kernels>), ...);
}

template <class Kernel>
struct AtRow {
  Kernel kernel;
  __device__ void operator()(size_t i) const { Run<float>(kernel, math::Rows{i, 1}); }
};

// Registers kernels for ForEachRow.
template <class... Kernels>
void ProvideRows() {
  ((KernelLaunch<Kernels>::function =
        [](size_t n, Stream& stream, const Kernels& kernel) {
          ForEachThread(n, stream, AtRow<Kernels>{kernel});
        }),
   ...);
}

}  // namespace cosplat::cuda

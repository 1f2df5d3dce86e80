// Arrays whose rows follow Gaussians that come, go or change places.
#pragma once

#include "splat/device/cuda/launch.cuh"
#include "splat/device/cuda/memory.h"

namespace cosplat::cuda {

// Rows of `width` numbers; from row first_zero on, zeros.
template <class T>
struct GatherRows {
  DeviceView<const T> from;
  DeviceView<const uint32_t> source;
  size_t width, first_zero;
  DeviceView<T> to;
  __device__ void operator()(size_t i) const {
    const size_t row = i / width;
    to[i] = row < first_zero ? from[source[row] * width + i % width] : T(0);
  }
};

template <class T>
void GatherArray(DeviceBuffer<T>& array,
                 DeviceBuffer<T>& spare,
                 size_t width,
                 DeviceView<const uint32_t> source,
                 size_t first_zero,
                 cudaStream_t stream) {
  spare.Refill(source.count * width);
  ForEach(spare.size(),
          stream,
          GatherRows<T>{std::as_const(array).view(), source, width, first_zero, spare.view()});
  array.swap(spare);
}

}  // namespace cosplat::cuda

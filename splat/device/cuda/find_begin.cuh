// Groups among sorted keys.
#pragma once

#include "splat/device/cuda/memory.h"

namespace cosplat::cuda {

// begin[g]: where key g begins among ascending keys, the first that is not less; for every g.
struct FindBegin {
  DeviceView<const uint32_t> keys;
  DeviceView<uint32_t> begin;
  __device__ void operator()(size_t g) const {
    uint32_t low = 0, high = uint32_t(keys.count);
    while (low < high) {
      const uint32_t middle = low + (high - low) / 2;
      if (keys[middle] < g)
        low = middle + 1;
      else
        high = middle;
    }
    begin[g] = low;
  }
};

}  // namespace cosplat::cuda

// Sorting and adding up on the device (CUB).
#pragma once

#include <cstdint>

#include "splat/device/cuda/memory.h"

namespace cosplat::cuda {

// Keys with a value each, sorted in turn from one pair of arrays to another.
struct KeyedValues {
  DeviceBuffer<uint32_t> keys, values;
  DeviceBuffer<uint32_t> keys_swap, values_swap;

  void Refill(size_t n);
  size_t held() const;  // bytes
};

class Sorter {
 public:
  // Stable, by the lowest `bits` bits of the keys.
  void Sort(KeyedValues& pairs, int bits, cudaStream_t stream);
  // Each number becomes the sum of those before it.
  void ExclusiveSum(DeviceBuffer<uint64_t>& numbers, cudaStream_t stream);
  size_t held() const { return scratch_.capacity(); }

 private:
  DeviceBuffer<unsigned char> scratch_;
};

}  // namespace cosplat::cuda

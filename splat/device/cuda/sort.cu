#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "splat/device/cuda/sort.h"
#include "splat/device/memory_part.h"

namespace cosplat::cuda {

void KeyedValues::Refill(size_t n) {
  keys.Refill(n);
  values.Refill(n);
  keys_swap.Refill(n);
  values_swap.Refill(n);
}

size_t KeyedValues::held() const { return HeldBy(keys, values, keys_swap, values_swap); }

void Sorter::Sort(KeyedValues& pairs, int bits, cudaStream_t stream) {
  const size_t n = pairs.keys.size();
  if (n == 0) return;
  cub::DoubleBuffer<uint32_t> keys(pairs.keys.data(), pairs.keys_swap.data());
  cub::DoubleBuffer<uint32_t> values(pairs.values.data(), pairs.values_swap.data());
  size_t bytes = 0;
  Check(cub::DeviceRadixSort::SortPairs(nullptr, bytes, keys, values, n, 0, bits, stream),
        "cub::DeviceRadixSort");
  scratch_.Refill(bytes);
  Check(cub::DeviceRadixSort::SortPairs(scratch_.data(), bytes, keys, values, n, 0, bits, stream),
        "cub::DeviceRadixSort");
  if (keys.Current() != pairs.keys.data()) pairs.keys.swap(pairs.keys_swap);
  if (values.Current() != pairs.values.data()) pairs.values.swap(pairs.values_swap);
}

void Sorter::ExclusiveSum(DeviceBuffer<uint64_t>& numbers, cudaStream_t stream) {
  uint64_t* data = numbers.data();
  size_t bytes = 0;
  Check(cub::DeviceScan::ExclusiveSum(nullptr, bytes, data, data, numbers.size(), stream),
        "cub::DeviceScan");
  scratch_.Refill(bytes);
  Check(cub::DeviceScan::ExclusiveSum(scratch_.data(), bytes, data, data, numbers.size(), stream),
        "cub::DeviceScan");
}

}  // namespace cosplat::cuda

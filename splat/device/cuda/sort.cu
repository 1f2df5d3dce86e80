#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "splat/device/cuda/stream.h"
#include "splat/device/sort.h"

namespace cosplat::cuda {

void CudaStream::Sort(KeyedValues& pairs, int bits) {
  const size_t n = pairs.keys.size();
  if (n == 0) return;
  cub::DoubleBuffer<uint32_t> keys(pairs.keys.data(), pairs.keys_swap.data());
  cub::DoubleBuffer<uint32_t> values(pairs.values.data(), pairs.values_swap.data());
  size_t bytes = 0;
  Check(cub::DeviceRadixSort::SortPairs(nullptr, bytes, keys, values, n, 0, bits, stream_),
        "cub::DeviceRadixSort");
  scratch_.Refill(bytes, *this);
  Check(cub::DeviceRadixSort::SortPairs(scratch_.data(), bytes, keys, values, n, 0, bits, stream_),
        "cub::DeviceRadixSort");
  if (keys.Current() != pairs.keys.data()) pairs.keys.swap(pairs.keys_swap);
  if (values.Current() != pairs.values.data()) pairs.values.swap(pairs.values_swap);
}

void CudaStream::ExclusiveSum(Buffer<uint64_t>& numbers) {
  uint64_t* data = numbers.data();
  size_t bytes = 0;
  Check(cub::DeviceScan::ExclusiveSum(nullptr, bytes, data, data, numbers.size(), stream_),
        "cub::DeviceScan");
  scratch_.Refill(bytes, *this);
  Check(cub::DeviceScan::ExclusiveSum(scratch_.data(), bytes, data, data, numbers.size(), stream_),
        "cub::DeviceScan");
}

}  // namespace cosplat::cuda

// CUB's radix sort as splat/*/cuda uses it, on the host (cuda_runtime.h beside this folder).
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "tests/support/cuda_on_host/cuda_runtime.h"

namespace cub {

template <class T>
struct DoubleBuffer {
  T* d_buffers[2];
  int selector = 0;
  DoubleBuffer(T* current, T* alternate) : d_buffers{current, alternate} {}
  T* Current() const { return d_buffers[selector]; }
  T* Alternate() const { return d_buffers[1 - selector]; }
};

struct DeviceRadixSort {
  // The result is always in the other buffer: whoever takes it to be in the first is wrong.
  template <class Key, class Value>
  static cudaError_t SortPairs(void* scratch,
                               size_t& scratch_bytes,
                               DoubleBuffer<Key>& keys,
                               DoubleBuffer<Value>& values,
                               size_t n,
                               int begin_bit,
                               int end_bit,
                               cudaStream_t) {
    if (!scratch) {
      scratch_bytes = 64;
      return cudaSuccess;
    }
    cuda_on_host::Enqueue([=, key = keys, value = values] {
      const uint64_t mask = (uint64_t(1) << end_bit) - (uint64_t(1) << begin_bit);
      std::vector<size_t> order(n);
      std::iota(order.begin(), order.end(), size_t(0));
      std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return (key.Current()[a] & mask) < (key.Current()[b] & mask);
      });
      for (size_t i = 0; i < n; ++i) {
        key.Alternate()[i] = key.Current()[order[i]];
        value.Alternate()[i] = value.Current()[order[i]];
      }
    });
    keys.selector = 1 - keys.selector;
    values.selector = 1 - values.selector;
    return cudaSuccess;
  }
};

}  // namespace cub

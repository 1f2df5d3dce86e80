// Key-value pairs for Stream::Sort, which alternates between two pairs of buffers.
#pragma once

#include <cstdint>

#include "splat/device/buffer.h"

namespace cosplat {

// A float as a sort key: non-negative floats have the order of their bits.
COSPLAT_HD uint32_t BitsOf(float x) {
  union {
    float value;
    uint32_t bits;
  } u{x};
  return u.bits;
}

struct KeyedValues {
  Buffer<uint32_t> keys, values;
  Buffer<uint32_t> keys_swap, values_swap;

  void Refill(size_t n, Stream& stream) {
    for (Buffer<uint32_t>* b : {&keys, &values, &keys_swap, &values_swap}) b->Refill(n, stream);
  }
  size_t allocated_bytes() const {
    return AllocatedBytes(keys, values, keys_swap, values_swap);
  }  // bytes
};

}  // namespace cosplat

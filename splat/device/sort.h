// Keys with a value each, sorted by Stream::Sort in turn from one pair of buffers to another.
#pragma once

#include <cstdint>

#include "splat/device/buffer.h"

namespace cosplat {

// As a key: those that are not negative sort as their bits.
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
  size_t held() const { return HeldBy(keys, values, keys_swap, values_swap); }  // bytes
};

}  // namespace cosplat

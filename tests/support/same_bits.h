// Compares bits, not values: -0 and 0 differ, a NaN is itself.
#pragma once

#include <cstring>

#include "splat/device/buffer.h"

namespace cosplat::test {

inline bool SameBits(View<const float> a, View<const float> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data, b.data, a.size() * sizeof(float)) == 0);
}

}  // namespace cosplat::test

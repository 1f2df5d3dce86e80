// Reordering of per-Gaussian arrays when Gaussians are added, removed or permuted, and lookup of
// groups in sorted keys.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/device/for_each.h"

namespace cosplat {

// Copies rows of `width` values; rows from first_zero on are zero.
template <class T>
struct GatherRow {
  View<const T> from;
  View<const uint32_t> source;
  size_t width, first_zero;
  View<T> to;
  COSPLAT_HD void operator()(size_t row) const {
    const size_t out = row * width;
    if (row < first_zero) {
      const size_t in = source[row] * width;
      for (size_t k = 0; k < width; ++k) to[out + k] = from[in + k];
    } else {
      for (size_t k = 0; k < width; ++k) to[out + k] = T{};
    }
  }
};

// Row i becomes the previous row source[i]; rows from first_zero on are zero. Swaps with `spare`.
template <class T>
void GatherRows(Buffer<T>& array,
                Buffer<T>& spare,
                size_t width,
                View<const uint32_t> source,
                size_t first_zero,
                Stream& stream) {
  spare.Refill(source.count * width, stream);
  if (width != 0)
    ForEach(
        source.count, stream, GatherRow<T>{array.view(), source, width, first_zero, spare.view()});
  array.swap(spare);
}

// Lower bound of g in ascending keys, that is, the first index whose key is not less.
COSPLAT_HD uint32_t LowerBound(View<const uint32_t> keys, size_t g) {
  uint32_t low = 0, high = uint32_t(keys.count);
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (keys[middle] < g)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}
struct FindBegin {
  View<const uint32_t> keys;
  View<uint32_t> begin;
  COSPLAT_HD void operator()(size_t g) const { begin[g] = LowerBound(keys, g); }
};

}  // namespace cosplat

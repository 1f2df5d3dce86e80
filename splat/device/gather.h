// Arrays whose rows follow Gaussians that come, go or change places; and groups among sorted keys.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/device/for_each.h"

namespace cosplat {

// Rows of `width` numbers; from row first_zero on, zeros.
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

// Row i becomes what row source[i] was; from first_zero on, zeros. `spare` takes turns with it.
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

// begin[g]: where key g begins among ascending keys, the first that is not less; for every g.
struct FindBegin {
  View<const uint32_t> keys;
  View<uint32_t> begin;
  COSPLAT_HD void operator()(size_t g) const {
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

}  // namespace cosplat

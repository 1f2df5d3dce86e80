// For each of many rows the nearest of a few thousand others: what k-means (splat/io/kmeans.h)
// spends its time on. Compiled per instruction set, run over oneTBB.
#pragma once

#include <cstdint>

#include "splat/device/buffer.h"

namespace cosplat {

struct NearestRow {
  uint32_t index = 0;   // of several that are equally near, the first
  float distance2 = 0;  // squared Euclidean distance
};

// rows: [N, width]; of: [K, width], finite, 1 <= K < 2^24. nearest: [N], overwritten. The same bits
// for any number of threads.
void FindNearestRows(View<const float> rows,
                     View<const float> of,
                     size_t width,
                     View<NearestRow> nearest);

}  // namespace cosplat

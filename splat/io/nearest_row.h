// Finds for each of many rows the nearest of a few thousand others, which takes most of the time of
// k-means (splat/io/kmeans.h). Compiled per instruction set, run in parallel by oneTBB.
#pragma once

#include <cstdint>

#include "splat/device/buffer.h"

namespace cosplat {

struct NearestRow {
  uint32_t index = 0;   // the lowest of those at equal distance
  float distance2 = 0;  // squared Euclidean distance
};

// rows: [N, width]; of: [K, width], finite, 1 <= K < 2^24. nearest: [N], overwritten. Bit-identical
// for any number of threads.
void FindNearestRows(View<const float> rows,
                     View<const float> of,
                     size_t width,
                     View<NearestRow> nearest);

}  // namespace cosplat

// k-means (Lloyd 1982): represents many rows by a few thousand centres.
//
// The initial centres are rows of a random sample, drawn with probability proportional to weight.
// They are moved over the sample, then once over all rows. Sums run in row order, so that a seed
// gives bit-identical results for any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"

namespace cosplat {

struct KMeansSettings {
  size_t centers = 8192;    // at most; fewer if there are fewer rows
  int iterations = 10;      // over the sample
  size_t sample = 1 << 16;  // rows
  uint64_t seed = 0;
};

struct Clusters {
  Buffer<float> centers;          // [K, width]
  std::vector<uint32_t> nearest;  // [N] index of each row's centre
};

// rows: [N, width], finite; weight: [N] > 0, weight of a row in its centre's mean.
Clusters KMeans(View<const float> rows,
                size_t width,
                View<const float> weight,
                const KMeansSettings& settings);

// What takes most of its time, in nearest_row.cpp: compiled per instruction set, run in parallel by
// oneTBB.
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

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

}  // namespace cosplat

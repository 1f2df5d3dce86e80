// k-means: a few thousand rows that stand for many (Lloyd 1982).
//
// The first centres are rows drawn at random, heavy ones rather; they move over a sample of the
// rows, then once over all. Sums run in the rows' order, so that a seed gives the same bits for any
// number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"

namespace cosplat {

struct KMeansSettings {
  size_t centers = 8192;    // at most this many; fewer where there are fewer rows
  int iterations = 10;      // over the sample
  size_t sample = 1 << 16;  // rows
  uint64_t seed = 0;
};

struct Clusters {
  Buffer<float> centers;          // [K, width]
  std::vector<uint32_t> nearest;  // [N] centre of each row
};

// rows: [N, width], finite; weight: [N] > 0, how much a row pulls at its centre.
Clusters KMeans(View<const float> rows,
                size_t width,
                View<const float> weight,
                const KMeansSettings& settings);

}  // namespace cosplat

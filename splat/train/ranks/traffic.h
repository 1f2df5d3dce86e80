// What the ranks of a training send, calculated: for docs/large-scenes.md and tests/scale/model,
// and against what Ranks::bytes_sent counts.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

// What ranks exchange (splat/train/ranks/ranks.h), counted since the start or since resuming, over
// all of them. Calculated from the groups: TrafficOf.
struct ExchangeStatistics {
  size_t ranks = 1;
  uint64_t steps = 0;           // of several views
  uint64_t views = 0;           // of those
  uint64_t groups_drawn = 0;    // summed over views: with a visible Gaussian
  uint64_t groups_updated = 0;  // summed over steps: with one that is visible in a view
  uint64_t assembled = 0;       // numbers of Gaussians that all ranks were to have
  uint64_t handed_over = 0;     // numbers of Gaussians that changed hands, and for checkpoints
  uint64_t bytes_sent = 0;
  double seconds = 0;  // mean over the ranks, waiting included
};

// Bytes, over all ranks. of: counts of groups, numbers and views. A rank owns an even share of the
// groups that a view draws, as it nearly does (splat/train/ranks/row_share.h).
double TrafficOf(const ExchangeStatistics& of);

}  // namespace cosplat

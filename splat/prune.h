// Pruning by plasticity: which Gaussians may go.
//
// Score (DCSHARP): the mean of |dL/ds| (s: the three standard deviations) over the iterations in
// which the Gaussian was visible since the last densification. A Gaussian whose shape the loss no
// longer moves is the least significant. Groups are triangles for avatars and one group for a
// scene; nothing here knows meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/buffer.h"

namespace cosplat {

struct PruneRequest {
  View<const float> score;     // [N] >= 0
  View<const uint8_t> exempt;  // [N] 1: unseen or new, never removed for its score
  View<const int32_t> group;   // [N] group of each; empty: all in one group
  size_t remove_lowest = 0;    // how many go for their score, over all groups
  int group_cap = 0;           // more than this in a group: its lowest scores go first; 0: no cap
  int group_floor = 0;         // never leave a group that had any with fewer
};

// Indices to remove, ascending. Equal scores: the lower index goes.
std::vector<uint32_t> SelectForPruning(const PruneRequest& request);

}  // namespace cosplat

// Which Gaussians a round of pruning takes, given their scores (splat/prune/pruner.h). Groups are
// triangles for avatars and one group for a scene; nothing here knows meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"

namespace cosplat {

struct PruneRequest {
  View<const float> score;     // [N] lowest go first
  View<const uint8_t> exempt;  // [N] 1: unseen or new, never removed for its score
  View<const int32_t> group;   // [N] group of each; empty: all in one group
  size_t remove_lowest = 0;    // how many go for their score, over all groups
  int group_cap = 0;           // more than this in a group: its lowest scores go first; 0: no cap
  int group_floor = 0;         // never leave a group that had any with fewer
};

// Indices to remove, ascending. Equal scores: the lower index goes.
std::vector<uint32_t> SelectForPruning(const PruneRequest& request);

}  // namespace cosplat

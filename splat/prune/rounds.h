// When a rule prunes, and how many go: shared by the rules that rank.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/train/schedule.h"

namespace cosplat {

// Rounds at `first`, `first + every`, ... up to `last`.
struct PruneRounds {
  int first = 0;
  int every = 1;
  int last = 0;

  // Steps of a run of 30,000, scaled to this one.
  static PruneRounds Scaled(int iterations, int first, int every, int last) {
    const auto scaled = [iterations](int steps) {
      return std::max(1, int(std::lround(double(steps) * iterations / 30000)));
    };
    return {scaled(first), scaled(every), scaled(last)};
  }
  bool At(int iteration) const {
    return iteration >= first && iteration <= last && (iteration - first) % every == 0;
  }
  // After this one.
  int LeftAfter(int iteration) const { return std::max(0, (last - iteration) / every); }
};

// How many of `count` go so that the same ratio in each of the rounds left reaches the target.
inline size_t RemovalTowards(size_t target, size_t count, int rounds_left) {
  if (count <= target) return 0;
  const double ratio = std::pow(double(target) / double(count), 1.0 / (rounds_left + 1));
  return count - std::max(target, size_t(std::llround(double(count) * ratio)));
}

inline size_t ShareOf(double share, size_t count) { return size_t(share * double(count)); }

// A share, but not below the target, where there is one.
inline size_t ShareDownTo(size_t target, double share, size_t count) {
  return std::min(ShareOf(share, count), count - std::min(target, count));
}

// The rounds of DCSHARP: at each densification, 2 % each. To keep to a count there is one more when
// they are over, since each adds Gaussians that cannot be judged yet.
struct DensificationRounds {
  static constexpr double kShare = 0.02;  // DCSHARP's released code
  Schedule schedule;
  size_t target = 0;  // 0: no count to keep to

  bool At(int iteration) const {
    return schedule.DensifiesAt(iteration) || (target > 0 && iteration == schedule.densify_until);
  }
  size_t Remove(size_t count, int iteration) const {
    if (target == 0) return ShareOf(kShare, count);
    const bool one_more = iteration < schedule.densify_until;
    return RemovalTowards(target, count, schedule.DensificationsAfter(iteration) + one_more);
  }
};

// Which Gaussians a round of pruning takes, given their scores (splat/prune/pruner.h). Groups are
// triangles for avatars and one group for a scene; nothing here knows meshes.

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

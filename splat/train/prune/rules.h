// What pruning rules are made of: when they prune and how many Gaussians they remove; and the rules
// of the product, of which splat/train/prune/pruner.h has the table.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/train/optimize/schedule.h"
#include "splat/train/prune/importance.h"
#include "splat/train/prune/pruner.h"

namespace cosplat {

// Rounds at `first`, `first + every`, ... up to `last`.
struct PruneRounds {
  int first = 0;
  int every = 1;
  int last = 0;

  // Step numbers of a 30,000-step run, scaled to `iterations`.
  static PruneRounds Scaled(int iterations, int first, int every, int last) {
    const auto scaled = [iterations](int steps) {
      return std::max(1, int(std::lround(double(steps) * iterations / 30000)));
    };
    return {scaled(first), scaled(every), scaled(last)};
  }
  bool At(int iteration) const {
    return iteration >= first && iteration <= last && (iteration - first) % every == 0;
  }
  // Rounds left after this iteration.
  int LeftAfter(int iteration) const { return std::max(0, (last - iteration) / every); }
};

// How many of `count` to remove so that the same ratio in all remaining rounds reaches the target.
inline size_t RemovalTowards(size_t target, size_t count, int rounds_left) {
  if (count <= target) return 0;
  const double ratio = std::pow(double(target) / double(count), 1.0 / (rounds_left + 1));
  return count - std::max(target, size_t(std::llround(double(count) * ratio)));
}

inline size_t ShareOf(double share, size_t count) { return size_t(share * double(count)); }

// A share of `count`, but leaving at least `target`.
inline size_t ShareDownTo(size_t target, double share, size_t count) {
  return std::min(ShareOf(share, count), count - std::min(target, count));
}

// DCSHARP's rounds: 2 % at each densification. With a target there is another round when
// densification has ended, since each densification adds Gaussians that cannot be ranked yet.
struct DensificationRounds {
  static constexpr double kShare = 0.02;  // DCSHARP's released code
  Schedule schedule;
  size_t target = 0;  // 0: none

  bool At(int iteration) const {
    return schedule.DensifiesAt(iteration) || (target > 0 && iteration == schedule.densify_until);
  }
  size_t Remove(size_t count, int iteration) const {
    if (target == 0) return ShareOf(kShare, count);
    const bool one_more = iteration < schedule.densify_until;
    return RemovalTowards(target, count, schedule.DensificationsAfter(iteration) + one_more);
  }
};

// Selects the Gaussians that a pruning round removes by their scores (splat/train/prune/pruner.h).
// Groups are triangles for avatars, and a single group for a scene; this code does not depend on
// meshes.

struct PruneRequest {
  View<const float> score;     // [N] the lowest are removed first
  View<const uint8_t> exempt;  // [N] 1: unseen or new, not removed by score
  View<const int32_t> group;   // [N] group index; empty: a single group
  size_t remove_lowest = 0;    // number to remove by score, over all groups
  int group_cap = 0;           // maximum per group: the lowest scores above it go first; 0: none
  int group_floor = 0;         // minimum to leave in a group that had any
  // By score, at most so many that the sum of their scores is within this.
  double score_limit = std::numeric_limits<double>::infinity();
};

// Indices to remove, ascending. Of equal scores, the lower index is removed.
std::vector<uint32_t> SelectForPruning(const PruneRequest& request);

// Contributions over all frames of the context.
inline std::vector<Contribution> ContributionsIn(const PruneContext& c) {
  return c.images.Contributions({c.frames, c.degree, c.background, c.frames.size()});
}

// Prunes in DCSHARP's rounds (DensificationRounds), which count what to remove of what is ranked.
std::unique_ptr<Pruner> MakeDensificationPruner(const PruneSettings& settings,
                                                const PrunedRun& run,
                                                PruneRound (*rank)(const PruneContext& context));

std::unique_ptr<Pruner> MakeLeaveOneOutPruner(const PruneSettings& settings, const PrunedRun& run);
std::unique_ptr<Pruner> MakeDcsharpPruner(const PruneSettings& settings, const PrunedRun& run);
std::unique_ptr<Pruner> MakeLpPruner(const PruneSettings& settings, const PrunedRun& run);
std::unique_ptr<Pruner> MakeOpacityPruner(const PruneSettings& settings, const PrunedRun& run);

}  // namespace cosplat

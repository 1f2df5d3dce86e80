// What the files of pruning rules have in common, and the rules of the product
// (splat/train/prune/pruner.h has their table).
#pragma once

#include <memory>
#include <vector>

#include "splat/train/prune/importance.h"
#include "splat/train/prune/pruner.h"

namespace cosplat {

// Contributions over all frames of the context, or at most `most_frames` of them.
inline std::vector<Contribution> ContributionsIn(const PruneContext& c,
                                                 size_t most_frames = size_t(-1)) {
  return c.images.Contributions({c.frames, c.degree, c.background, most_frames});
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

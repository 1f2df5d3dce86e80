// The pruning rules, one per file (splat/train/prune/pruner.h documents them; MakePruner selects
// one).
#pragma once

#include <memory>

#include "splat/train/prune/importance.h"
#include "splat/train/prune/pruner.h"

namespace cosplat {

// Contributions over all frames of the context, or at most `most_frames` of them.
inline std::vector<Contribution> ContributionsIn(const PruneContext& c,
                                                 size_t most_frames = size_t(-1)) {
  return c.images.Contributions({c.frames, c.degree, c.background, most_frames});
}

std::unique_ptr<Pruner> MakeLeaveOneOutPruner(const PruneSettings& settings,
                                              const Schedule& schedule,
                                              int iterations);
std::unique_ptr<Pruner> MakeDcsharpPruner(const PruneSettings& settings, const Schedule& schedule);
std::unique_ptr<Pruner> MakeDcsharpReleasedPruner(const Schedule& schedule, size_t gaussians);
std::unique_ptr<Pruner> MakeLightGaussianPruner(const PruneSettings& settings, int iterations);
std::unique_ptr<Pruner> MakeCompactPruner(const PruneSettings& settings,
                                          const Schedule& schedule,
                                          int iterations,
                                          size_t gaussians);
std::unique_ptr<Pruner> MakeLpPruner(const PruneSettings& settings, int iterations);
std::unique_ptr<Pruner> MakeSpeedyPruner(const PruneSettings& settings, int iterations);
std::unique_ptr<Pruner> MakeOpacityPruner(const PruneSettings& settings, const Schedule& schedule);
std::unique_ptr<Pruner> MakeRandomPruner(const PruneSettings& settings, const Schedule& schedule);

}  // namespace cosplat

// The rules of pruning that the product's are compared with (splat/train/prune/pruner.h).
#pragma once

#include <memory>

#include "splat/train/prune/pruner.h"

namespace cosplat {

// Adds them to the program's.
void RegisterStudyRules();

std::unique_ptr<Pruner> MakeCompactPruner(const PruneSettings& settings, const PrunedRun& run);
std::unique_ptr<Pruner> MakeDcsharpReleasedPruner(const PruneSettings& settings,
                                                  const PrunedRun& run);
std::unique_ptr<Pruner> MakeLightGaussianPruner(const PruneSettings& settings,
                                                const PrunedRun& run);
std::unique_ptr<Pruner> MakeSpeedyPruner(const PruneSettings& settings, const PrunedRun& run);

}  // namespace cosplat

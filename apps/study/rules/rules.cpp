#include "apps/study/rules/rules.h"

#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

PruneRound RankAtRandom(const PruneContext& context) {
  PruneRound round;
  for (size_t i = 0; i < context.gaussians.size(); ++i)
    round.score.push_back(context.rng.Uniform());
  return round;
}

// Shows what ranking is worth at all.
std::unique_ptr<Pruner> MakeRandomPruner(const PruneSettings& settings, const PrunedRun& run) {
  return MakeDensificationPruner(settings, run, RankAtRandom);
}

}  // namespace

void RegisterStudyRules() {
  RegisterPruneRule(
      {.name = "dcsharp-released", .make = MakeDcsharpReleasedPruner, .on_host = true});
  RegisterPruneRule({.name = "lightgaussian", .make = MakeLightGaussianPruner, .ranks = true});
  RegisterPruneRule({.name = "compact", .make = MakeCompactPruner, .learns_mask = true});
  RegisterPruneRule({.name = "speedy", .make = MakeSpeedyPruner, .ranks = true});
  RegisterPruneRule({.name = "random", .make = MakeRandomPruner, .ranks = true});
}

}  // namespace cosplat

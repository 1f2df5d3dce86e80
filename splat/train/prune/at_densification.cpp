// Rules that prune at each densification:
//
// DCSHARP: shape-aware pruning by plasticity. The supplement keeps the Top-K.
// Opacity: the least opaque go, the baseline that any score must beat.
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

class DensificationPruner : public Pruner {
 public:
  DensificationPruner(const DensificationRounds& rounds, PruneRound (*rank)(const PruneContext&))
      : rounds_(rounds), rank_(rank) {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    PruneRound round = rank_(context);
    round.remove = rounds_.Remove(context.gaussians.size(), context.iteration);
    return round;
  }

 private:
  DensificationRounds rounds_;
  PruneRound (*rank_)(const PruneContext&);
};

PruneRound RankByOpacity(const PruneContext& context) {
  const Buffer<float>& logits = context.gaussians.values[kOpacityLogit];
  return {{logits.begin(), logits.end()}, {}, 0};
}

}  // namespace

PruneRound RankByPlasticity(const PruneContext& context) {
  PruneRound round;
  for (size_t i = 0; i < context.gaussians.size(); ++i) {
    round.score.push_back(context.statistics.MeanPlasticity(i));
    round.exempt.push_back(!(context.statistics.visible[i] > 0));  // new or unseen
  }
  return round;
}

std::unique_ptr<Pruner> MakeDensificationPruner(const PruneSettings& settings,
                                                const PrunedRun& run,
                                                PruneRound (*rank)(const PruneContext&)) {
  return std::make_unique<DensificationPruner>(DensificationRounds{run.schedule, settings.target},
                                               rank);
}

std::unique_ptr<Pruner> MakeDcsharpPruner(const PruneSettings& settings, const PrunedRun& run) {
  return MakeDensificationPruner(settings, run, RankByPlasticity);
}

std::unique_ptr<Pruner> MakeOpacityPruner(const PruneSettings& settings, const PrunedRun& run) {
  return MakeDensificationPruner(settings, run, RankByOpacity);
}

}  // namespace cosplat

// Removes the least opaque, in DCSHARP's rounds: the baseline that any score must beat.
#include "splat/train/prune/rounds.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

class OpacityPruner : public Pruner {
 public:
  OpacityPruner(const PruneSettings& settings, const Schedule& schedule)
      : rounds_{schedule, settings.target} {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    for (size_t i = 0; i < n; ++i) round.score.push_back(context.gaussians.at(kOpacityLogit, i)[0]);
    round.remove = rounds_.Remove(n, context.iteration);
    return round;
  }

 private:
  DensificationRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeOpacityPruner(const PruneSettings& settings, const Schedule& schedule) {
  return std::make_unique<OpacityPruner>(settings, schedule);
}

}  // namespace cosplat

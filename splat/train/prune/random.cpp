// Removes random Gaussians, in DCSHARP's rounds: shows what ranking is worth at all.
#include "splat/train/prune/rounds.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

class RandomPruner : public Pruner {
 public:
  RandomPruner(const PruneSettings& settings, const Schedule& schedule)
      : rounds_{schedule, settings.target} {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    for (size_t i = 0; i < n; ++i) round.score.push_back(context.rng.Uniform());
    round.remove = rounds_.Remove(n, context.iteration);
    return round;
  }

 private:
  DensificationRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeRandomPruner(const PruneSettings& settings, const Schedule& schedule) {
  return std::make_unique<RandomPruner>(settings, schedule);
}

}  // namespace cosplat

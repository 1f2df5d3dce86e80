// Any go, in the rounds of DCSHARP: what ranking is worth at all.
#include "splat/prune/rounds.h"
#include "splat/prune/rules.h"

namespace cosplat {
namespace {

constexpr double kShare = 0.02;

class RandomPruner : public Pruner {
 public:
  RandomPruner(const PruneSettings& settings, const Schedule& schedule)
      : settings_(settings), rounds_{schedule, settings.target > 0} {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    for (size_t i = 0; i < n; ++i) round.score.push_back(context.rng.Uniform());
    round.remove = settings_.target == 0
                       ? ShareOf(kShare, n)
                       : RemovalTowards(settings_.target, n, rounds_.LeftAfter(context.iteration));
    return round;
  }

 private:
  PruneSettings settings_;
  DensificationRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeRandomPruner(const PruneSettings& settings, const Schedule& schedule) {
  return std::make_unique<RandomPruner>(settings, schedule);
}

}  // namespace cosplat

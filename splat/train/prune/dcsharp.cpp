// DCSHARP: shape-aware pruning by plasticity. Score: the mean of |dL/ds| (s: the three standard
// deviations) over the steps since the last densification in which the Gaussian was visible. The
// least significant Gaussians are those whose shape the loss no longer changes. Prunes at each
// densification. The supplement keeps the Top-K.
#include "splat/train/prune/rounds.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

class DcsharpPruner : public Pruner {
 public:
  DcsharpPruner(const PruneSettings& settings, const Schedule& schedule)
      : rounds_{schedule, settings.target} {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const DensityStatistics& statistics = context.statistics;
    const size_t n = context.gaussians.size();
    PruneRound round{std::vector<float>(n, 0.0f), std::vector<uint8_t>(n, 1), 0};
    for (size_t i = 0; i < n; ++i) {
      round.score[i] = statistics.MeanPlasticity(i);
      round.exempt[i] = !(statistics.visible[i] > 0);  // new or unseen
    }
    round.remove = rounds_.Remove(n, context.iteration);
    return round;
  }

 private:
  DensificationRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeDcsharpPruner(const PruneSettings& settings, const Schedule& schedule) {
  return std::make_unique<DcsharpPruner>(settings, schedule);
}

}  // namespace cosplat

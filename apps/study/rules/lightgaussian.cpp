// LightGaussian (Fan et al. 2024): global significance, sum over views and pixels of
// opacity T (V / V_90)^0.1. Removes 66 % at once and then fine-tunes the rest; here that is at step
// 25,000 of 30,000, so that the run is as long as those of other rules.
#include "apps/study/rules/rules.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

constexpr double kLightGaussianShare = 0.66;
constexpr int kRound = 25000;  // of 30,000

class LightGaussianPruner : public Pruner {
 public:
  LightGaussianPruner(const PruneSettings& settings, int iterations)
      : settings_(settings), rounds_(PruneRounds::Scaled(iterations, kRound, 1, kRound)) {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    round.score = Significance(context.gaussians, ContributionsIn(context));
    round.remove = settings_.target == 0 ? ShareOf(kLightGaussianShare, n)
                                         : RemovalTowards(settings_.target, n, 0);
    return round;
  }

 private:
  PruneSettings settings_;
  PruneRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeLightGaussianPruner(const PruneSettings& settings,
                                                const PrunedRun& run) {
  return std::make_unique<LightGaussianPruner>(settings, run.iterations);
}

}  // namespace cosplat

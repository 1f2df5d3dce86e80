// Speedy-Splat (Hanson et al. 2025): sensitivity of the images to a Gaussian's falloff, sum over
// views and pixels of (d(red + green + blue)/d(falloff))^2. Every 3,000 steps from step 6,000 of
// 30,000: removes 80 % while densification refills the model (soft), 30 % afterwards (hard). With a
// target, the hard rounds reach it.
#include "apps/study/rules/rules.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

constexpr double kSoftShare = 0.8, kHardShare = 0.3;

class SpeedyPruner : public Pruner {
 public:
  SpeedyPruner(const PruneSettings& settings, int iterations)
      : settings_(settings),
        soft_(PruneRounds::Scaled(iterations, 6000, 3000, 14999)),
        hard_(PruneRounds::Scaled(iterations, 15000, 3000, 27000)) {}

  bool PrunesAt(int iteration) const override { return soft_.At(iteration) || hard_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    for (const Contribution& c : ContributionsIn(context)) round.score.push_back(c.sensitivity);
    if (!hard_.At(context.iteration))
      round.remove = ShareDownTo(settings_.target, kSoftShare, n);
    else if (settings_.target == 0)
      round.remove = ShareOf(kHardShare, n);
    else
      round.remove = RemovalTowards(settings_.target, n, hard_.LeftAfter(context.iteration));
    return round;
  }

 private:
  PruneSettings settings_;
  PruneRounds soft_, hard_;
};

}  // namespace

std::unique_ptr<Pruner> MakeSpeedyPruner(const PruneSettings& settings, const PrunedRun& run) {
  return std::make_unique<SpeedyPruner>(settings, run.iterations);
}

}  // namespace cosplat

// Leave-one-out pruning. Score: the squared change of the training images when only this Gaussian
// is removed (splat/render/contribution.h): exact, not a derivative. A few rounds after
// densification, so that neighbours have time to compensate.
#include <algorithm>

#include "splat/base/error.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

constexpr size_t kMaxFrames = 100;
constexpr double kShareOfRound = 0.2;  // per round, if there is no target

class LeaveOneOutPruner : public Pruner {
 public:
  // Five rounds over the first two fifths of the steps after densification.
  LeaveOneOutPruner(const PruneSettings& settings, int first, int iterations)
      : settings_(settings) {
    rounds_.first = first;
    rounds_.every = std::max(1, (iterations - first) / 10);
    rounds_.last = first + 4 * rounds_.every;
  }

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    for (const Contribution& c : ContributionsIn(context, kMaxFrames))
      round.score.push_back(c.change);
    round.remove = settings_.target == 0
                       ? ShareOf(kShareOfRound, n)
                       : RemovalTowards(settings_.target, n, rounds_.LeftAfter(context.iteration));
    return round;
  }

 private:
  PruneSettings settings_;
  PruneRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeLeaveOneOutPruner(const PruneSettings& settings, const PrunedRun& run) {
  const int first = std::max(1, run.schedule.densify_until);
  if (first + 4 >= run.iterations)
    throw Error("--prune leave-one-out",
                "densification until step " + std::to_string(run.schedule.densify_until) + " of " +
                    std::to_string(run.iterations) + " leaves no steps for pruning");
  return std::make_unique<LeaveOneOutPruner>(settings, first, run.iterations);
}

}  // namespace cosplat

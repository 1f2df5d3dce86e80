// By what the pictures lose. Score: the squared change of the training pictures when this Gaussian
// alone is taken out (splat/contribution.h): exact, not a derivative. A few rounds once
// densification is over, so that neighbours have time to take a Gaussian's place.
#include "splat/importance.h"
#include "splat/prune/rounds.h"
#include "splat/prune/rules.h"

namespace cosplat {
namespace {

constexpr size_t kMostFrames = 100;
constexpr double kShare = 0.2;  // of each round, without a target

class LeaveOneOutPruner : public Pruner {
 public:
  LeaveOneOutPruner(const PruneSettings& settings, int iterations)
      : settings_(settings), rounds_(PruneRounds::Scaled(iterations, 15000, 1500, 21000)) {}

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    const size_t n = context.gaussians.size();
    PruneRound round;
    for (const Contribution& c : ContributionsToFrames(context.subject,
                                                       context.frames,
                                                       context.gaussians,
                                                       context.degree,
                                                       context.background,
                                                       kMostFrames))
      round.score.push_back(c.change);
    round.remove = settings_.target == 0
                       ? ShareOf(kShare, n)
                       : RemovalTowards(settings_.target, n, rounds_.LeftAfter(context.iteration));
    return round;
  }

 private:
  PruneSettings settings_;
  PruneRounds rounds_;
};

}  // namespace

std::unique_ptr<Pruner> MakeLeaveOneOutPruner(const PruneSettings& settings, int iterations) {
  return std::make_unique<LeaveOneOutPruner>(settings, iterations);
}

}  // namespace cosplat

// Leave-one-out pruning. Score: the squared change of the training images when only this Gaussian
// is removed (splat/render/contribution.h): exact, not a derivative. The images are drawn with a
// margin around them. A few rounds after densification, so that neighbours have time to compensate.
//
// Without a target a round removes as many of the lowest as the training images can do without: by
// its part of the tolerance in dB. First in question are those whose scores add up to the squared
// error that this allows, as they would if they were independent. Where they are not, such as thin
// layers that fade together, the images without them show it, and fewer are removed. How many these
// are depends on the scene, not on a number.
#include <algorithm>
#include <cmath>

#include "splat/base/error.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

constexpr size_t kMaxFrames = 100;
constexpr int kRounds = 5;
constexpr int kAttempts = 6;
// What the training images see only in part is at the edge of held-out ones: without it fox loses
// 0.35 dB there as a tenth of its Gaussians goes, with it none.
constexpr float kMargin = 0.25f;

class LeaveOneOutPruner : public Pruner {
 public:
  // The rounds are over the first two fifths of the steps after densification.
  LeaveOneOutPruner(const PruneSettings& settings, int first, int iterations)
      : settings_(settings) {
    rounds_.first = first;
    rounds_.every = std::max(1, (iterations - first) / (2 * kRounds));
    rounds_.last = first + (kRounds - 1) * rounds_.every;
  }

  bool PrunesAt(int iteration) const override { return rounds_.At(iteration); }

  PruneRound Rank(const PruneContext& context) override {
    PruneRound round;
    FrameChoice choice{context.frames, context.degree, context.background, kMaxFrames};
    choice.margin = kMargin;
    for (const Contribution& c : context.images.Contributions(choice))
      round.score.push_back(c.change);
    round.remove = round.score.size();
    if (settings_.target == 0)
      round.score_limit = LimitOf(round.score, context);
    else
      round.remove = RemovalTowards(
          settings_.target, round.score.size(), rounds_.LeftAfter(context.iteration));
    return round;
  }

 private:
  // The sum of the scores of those that the images can do without.
  double LimitOf(const std::vector<float>& score, const PruneContext& c) const {
    const FrameChoice choice{c.frames, c.degree, c.background, kMaxFrames};
    const double error = c.images.ErrorIn(choice).squared;
    const double allowed = error * (std::pow(10, settings_.tolerance / kRounds / 10) - 1);
    double limit = allowed;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const std::vector<uint32_t> lowest = SelectForPruning(
          {score, std::vector<uint8_t>(score.size(), 0), {}, score.size(), 0, 0, limit});
      std::vector<uint8_t> removed(score.size(), 0);
      double sum = 0;
      for (const uint32_t i : lowest) {
        removed[i] = 1;
        sum += score[i];
      }
      const double added = c.images.ErrorWithout(removed, choice).squared - error;
      if (added <= allowed) return limit;
      limit = sum * std::clamp(allowed / added, 0.1, 0.8);
    }
    return 0;
  }

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

#include "splat/train/budget.h"

#include <cmath>

#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr double kFirstShare = 0.25;  // of the Gaussians, tried first
constexpr double kMinShare = 0.02;
constexpr double kFineEnough = 1.2;  // ratio of the smallest passing to the largest failing count
constexpr int kMaxTrials = 5;        // besides the unpruned one

// Trial runs, each trained to the end from a checkpoint.
class Trials {
 public:
  Trials(const BudgetSettings& settings,
         Trainer& trainer,
         const std::function<void(size_t, const StepReport&)>& progress)
      : settings_(settings), trainer_(trainer), progress_(progress) {}

  void TrainUntil(int iteration) {
    while (trainer_.iteration() < iteration) progress_(trials_.size(), trainer_.Step());
  }
  void Run(const Trainer::Checkpoint& from, const PruneSettings& prune) {
    trainer_.Restore(from, prune);
    TrainUntil(trainer_.settings().iterations);
    trials_.push_back({trainer_.count(), trainer_.PsnrOf(settings_.held_out)});
  }
  bool LastHeld() const {
    return trials_.back().psnr >= trials_.front().psnr - settings_.tolerance_db;
  }
  const std::vector<BudgetTrial>& trials() const { return trials_; }

 private:
  const BudgetSettings& settings_;
  Trainer& trainer_;
  const std::function<void(size_t, const StepReport&)>& progress_;
  std::vector<BudgetTrial> trials_;
};

}  // namespace

BudgetReport FindBudget(const BudgetSettings& settings,
                        Trainer& trainer,
                        const std::function<void(size_t, const StepReport&)>& progress) {
  const int first = trainer.FirstPruneStep();
  if (first == 0) throw Error("--budget auto", "the pruning rule has no round in this run");
  if (settings.held_out.empty())
    throw Error("--budget auto", "there are too few training frames to hold any out");
  PruneSettings prune = trainer.settings().prune, none = prune;
  none.rule = PruneRule::kNone;
  none.target = 0;
  const Trainer::Checkpoint start = trainer.Save();
  trainer.HoldOut(settings.held_out);
  Trials trials(settings, trainer, progress);
  trials.TrainUntil(first - 1);
  const Trainer::Checkpoint before = trainer.Save();
  trials.Run(before, none);

  // Search over the logarithm of the count: from a quarter, halve while trials pass; once one has
  // failed, bisect.
  const double all = double(trials.trials()[0].gaussians);
  double held = 1, failed = 0;
  double share = kFirstShare;
  for (int k = 0; k < kMaxTrials && share >= kMinShare; ++k) {
    prune.target = size_t(std::max(1.0, std::round(share * all)));
    trials.Run(before, prune);
    (trials.LastHeld() ? held : failed) = share;
    if (failed > 0 && held / failed < kFineEnough) break;
    share = failed == 0 ? share / 2 : std::sqrt(held * failed);
  }
  BudgetReport report{trials.trials(), size_t(std::round(held * all))};
  prune.target = held < 1 ? report.chosen : 0;
  trainer.HoldOut({});
  trainer.Restore(start, held < 1 ? prune : none);
  return report;
}

std::vector<uint32_t> FramesForBudget(size_t count, bool video) {
  std::vector<uint32_t> frames;
  for (size_t f = 0; f < count; ++f)
    if (video ? f >= count - count / 5 : f % 8 == 4) frames.push_back(uint32_t(f));
  return frames;
}

}  // namespace cosplat

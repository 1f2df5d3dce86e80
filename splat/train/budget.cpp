#include "splat/train/budget.h"

#include <cmath>

#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr double kFirstShare = 0.25;  // of the Gaussians, tried first
constexpr double kMinShare = 0.02;
constexpr double kFineEnough = 1.2;  // ratio of the smallest passing to the largest failing count
constexpr size_t kMaxTrials = 5;     // besides the unpruned one

}  // namespace

BudgetSearch::BudgetSearch(const BudgetSettings& settings, Trainer& trainer)
    : settings_(settings),
      trainer_(trainer),
      prune_(trainer.settings().prune),
      unpruned_(prune_),
      first_round_(trainer.FirstPruneStep()),
      share_(kFirstShare) {
  if (first_round_ == 0) throw Error("--budget auto", "the pruning rule has no round in this run");
  if (settings.held_out.empty())
    throw Error("--budget auto", "there are too few training frames to hold any out");
  unpruned_.rule = "none";
  unpruned_.target = 0;
  start_ = trainer.Save();
  trainer.HoldOut(settings.held_out);
  if (first_round_ == 1) BeginTrial();
}

StepReport BudgetSearch::Step() {
  const StepReport step = trainer_.Step();
  if (!HasBefore()) {
    if (step.iteration == first_round_ - 1) BeginTrial();
  } else if (step.iteration == trainer_.settings().iterations) {
    EndTrial();
  }
  return step;
}

void BudgetSearch::BeginTrial() {
  if (!HasBefore()) before_ = trainer_.Save();
  if (trials() == 0) return trainer_.Restore(before_, unpruned_);
  prune_.target = size_t(std::max(1.0, std::round(share_ * UnprunedCount())));
  trainer_.Restore(before_, prune_);
}

bool BudgetSearch::LastHeld() const {
  return report_.trials.back().psnr >= report_.trials.front().psnr - settings_.tolerance_db;
}

// Searches over the logarithm of the count: from a quarter, halves while trials pass; once one has
// failed, bisects.
void BudgetSearch::EndTrial() {
  report_.trials.push_back({trainer_.count(), trainer_.PsnrOf(settings_.held_out)});
  bool fine = false;
  if (trials() > 1) {
    (LastHeld() ? held_ : failed_) = share_;
    fine = failed_ > 0 && held_ / failed_ < kFineEnough;
    if (!fine) share_ = failed_ == 0 ? share_ / 2 : std::sqrt(held_ * failed_);
  }
  if (!fine && trials() <= kMaxTrials && share_ >= kMinShare) return BeginTrial();
  done_ = true;
  report_.chosen = size_t(std::round(held_ * UnprunedCount()));
  prune_.target = held_ < 1 ? report_.chosen : 0;
  trainer_.HoldOut({});
  trainer_.Restore(start_, held_ < 1 ? prune_ : unpruned_);
}

void BudgetSearch::Serialize(StateArchive& a) {
  trainer_.Serialize(a);
  a.Value("budget.held", held_);
  a.Value("budget.failed", failed_);
  a.Value("budget.share", share_);
  a.ArrayUpTo("budget.trials", report_.trials, kMaxTrials);
  uint8_t has_before = HasBefore();
  a.Value("budget.has_before", has_before);
  a.Require(has_before || trials() == 0, "budget.trials", "are there before the first");
  if (has_before) trainer_.Serialize(a, before_);
}

std::vector<uint32_t> FramesForBudget(size_t count, bool video) {
  std::vector<uint32_t> frames;
  for (size_t f = 0; f < count; ++f)
    if (video ? f >= count - count / 5 : f % 8 == 4) frames.push_back(uint32_t(f));
  return frames;
}

}  // namespace cosplat

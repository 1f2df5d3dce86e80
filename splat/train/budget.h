// Finds how many Gaussians a scene needs: `--budget auto`.
//
// Part of the training frames is held out. From the state before the first round of pruning, the
// run is tried to its end, first without pruning and then with several smaller numbers of
// Gaussians, set as the target of the pruning rule. The budget is the smallest number that keeps
// the PSNR of the held-out frames within a tolerance of the unpruned run. Training then restarts
// from the beginning, with all frames and that number: the result is bit-identical to a run that
// was given the number.
#pragma once

#include <vector>

#include "splat/train/trainer.h"

namespace cosplat {

struct BudgetSettings {
  double tolerance_db = 0.2;       // loss of PSNR allowed on the held-out frames
  std::vector<uint32_t> held_out;  // frames to evaluate
};

// Result of one trial run.
struct BudgetTrial {
  size_t gaussians = 0;
  double psnr = 0;  // dB, of the held-out frames
};

struct BudgetReport {
  std::vector<BudgetTrial> trials;  // the first is the unpruned one
  size_t chosen = 0;                // Gaussians; the unpruned count if no smaller one passed
};

// The trial runs, step by step, so that a search can be interrupted and go on from a checkpoint.
class BudgetSearch {
 public:
  // The trainer, which must outlive this, must not have started. Its settings must name a rule that
  // ranks and keeps no state between rounds. Throws Error if there is no round to prune in or no
  // frame to evaluate.
  BudgetSearch(const BudgetSettings& settings, Trainer& trainer);

  // One step of a trial. With the last one the search is done: the trainer is then at its start
  // again, with its target set.
  StepReport Step();
  bool done() const { return done_; }
  size_t trials() const { return report_.trials.size(); }  // completed
  const BudgetReport& report() const { return report_; }   // once done

  // Writes the search, with its trainer, to a checkpoint, or reads it into a search that was just
  // constructed. Not once it is done. Throws Error as Trainer::Serialize does.
  void Serialize(StateArchive& archive);

 private:
  bool HasBefore() const { return !before_.state.gaussians.values[kOpacityLogit].empty(); }
  void BeginTrial();
  void EndTrial();
  double UnprunedCount() const { return double(report_.trials[0].gaussians); }
  bool LastHeld() const;

  BudgetSettings settings_;
  Trainer& trainer_;
  PruneSettings prune_, unpruned_;
  int first_round_;             // step
  Trainer::Checkpoint start_;   // of the run
  Trainer::Checkpoint before_;  // before the first round of pruning; empty until it is reached
  // Shares of the unpruned count: the fewest that passed, the most that failed (0: none), and that
  // of the current trial.
  double held_ = 1, failed_ = 0, share_;
  BudgetReport report_;
  bool done_ = false;
};

// Frames to hold out of `count`: every eighth of a set of images, the last fifth of a video.
std::vector<uint32_t> FramesForBudget(size_t count, bool video);

}  // namespace cosplat

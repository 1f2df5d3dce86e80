// How many Gaussians a scene needs: `--budget auto`.
//
// Part of the training frames is held out. Before the first round of pruning the run is tried to
// its end as it is, and from the same point with fewer and fewer Gaussians, by the rule of pruning;
// the fewest that keep the held-out frames' PSNR within a tolerance of the unpruned run's are the
// budget. Then the run begins anew, with all frames and that count: what comes out has the bits of
// a run that was told it.
#pragma once

#include <functional>
#include <vector>

#include "splat/train/trainer.h"

namespace cosplat {

struct BudgetSettings {
  double tolerance_db = 0.2;       // that the held-out frames may lose
  std::vector<uint32_t> held_out;  // frames to judge by
};

// One end of the run.
struct BudgetTrial {
  size_t gaussians = 0;
  double psnr = 0;  // dB, of the held-out frames
};

struct BudgetReport {
  std::vector<BudgetTrial> trials;  // the first is the unpruned one
  size_t chosen = 0;                // Gaussians; that of the unpruned run when none fewer held
};

// `progress`: called after every step, with the number of the trial (0: before the first).
// The trainer is one that has not begun; it is left so, with its target set. Its settings must name
// a rule that ranks and keeps nothing between rounds. Throws Error when there is no round to prune
// in or no frame to judge by.
BudgetReport FindBudget(const BudgetSettings& settings,
                        Trainer& trainer,
                        const std::function<void(size_t trial, const StepReport&)>& progress);

// Frames to hold out of `count`: of images every eighth, of a video its last fifth.
std::vector<uint32_t> FramesForBudget(size_t count, bool video);

}  // namespace cosplat

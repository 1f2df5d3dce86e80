// Finds how many Gaussians a scene needs: `--budget auto`.
//
// Part of the training frames is held out. From the state before the first round of pruning, the
// run is tried to its end, first without pruning and then with several smaller numbers of
// Gaussians, set as the target of the pruning rule. The budget is the smallest number that keeps
// the PSNR of the held-out frames within a tolerance of the unpruned run. Training then restarts
// from the beginning, with all frames and that number: the result is bit-identical to a run that
// was given the number.
#pragma once

#include <functional>
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

// `progress` is called after every step with the number of completed trials. The trainer must not
// have started; it is left in that state, with its target set. Its settings must name a rule that
// ranks and keeps no state between rounds. Throws Error if there is no round to prune in or no
// frame to evaluate.
BudgetReport FindBudget(const BudgetSettings& settings,
                        Trainer& trainer,
                        const std::function<void(size_t trial, const StepReport&)>& progress);

// Frames to hold out of `count`: every eighth of a set of images, the last fifth of a video.
std::vector<uint32_t> FramesForBudget(size_t count, bool video);

}  // namespace cosplat

// The parts of a run that both trainers share: progress, milestones, statistics.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/cosplat/options/train_options.h"
#include "apps/cosplat/run/run_checkpoint.h"
#include "splat/base/skipped.h"
#include "splat/eval/lpips.h"
#include "splat/train/trainer.h"

namespace cosplat {

// The network of --lpips; null if there is none. Throws Error as Lpips does.
std::shared_ptr<Lpips> LoadLpips(const TrainOptions& options);

// What a progress bar says of a step: a running mean of the loss, the number of Gaussians.
class LossLine {
 public:
  std::string operator()(const StepReport& step);

 private:
  double loss_ = NAN;
};

// All ranks call the hooks; rank 0 alone is to write.
struct RunHooks {
  std::shared_ptr<Ranks> ranks = OneRank();
  Lpips* lpips = nullptr;          // measures the held-out images; null: none
  std::function<void()> save;      // at --save_iterations and at the end
  std::function<void()> evaluate;  // at --test_iterations and the end; empty: nothing held out
};

// Trains, saves and evaluates; writes stats.json, skipped_frames.json (if any were skipped),
// results.json and per_view.json. Returns once everything is on disk; the checkpoint is left to the
// caller, who may have more to write. Throws Stopped (stop_signals.h), with a checkpoint written,
// at SIGINT and SIGTERM.
void RunTraining(const TrainOptions& options,
                 Trainer& trainer,
                 const std::vector<SkippedFrame>& skipped,
                 const RunHooks& hooks,
                 RunCheckpoint& checkpoint);

// Prints, unless quiet, that the folder holds this run already.
void PrintFinished(const TrainOptions& options);

// Prints, unless quiet, what --quality has set.
void PrintSettled(const TrainOptions& options);

// Prints, unless quiet, how far the run had come that is resumed.
void PrintResumed(const TrainOptions& options, int iteration);

// Throws Stopped, once a checkpoint is written or cannot be.
[[noreturn]] void StopWithCheckpoint(int signal,
                                     int iteration,
                                     const std::function<void()>& write_checkpoint);

// Evaluates the held-out images that were written and prints their figures, unless quiet.
void PrintEvaluation(const TrainOptions& options, Lpips* lpips);

// Prints the time it took and the number of Gaussians.
void PrintTrained(const TrainingStatistics& statistics);

}  // namespace cosplat

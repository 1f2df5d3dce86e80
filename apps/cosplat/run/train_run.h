// What both trainers do around the training loop: progress, milestones, figures.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/cosplat/options/train_options.h"
#include "splat/base/skipped.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct RunHooks {
  bool video = false;              // frames follow each other in time
  std::function<void()> save;      // at --save_iterations and at the end
  std::function<void()> evaluate;  // at --test_iterations and at the end; empty: nothing held out
};

// Trains, saves and evaluates; writes stats.json, budget.json (with --budget auto),
// skipped_frames.json (where there are any), results.json and per_view.json. Returns once all of it
// is on disk.
void RunTraining(const TrainOptions& options,
                 Trainer& trainer,
                 const std::vector<SkippedFrame>& skipped,
                 const RunHooks& hooks);

// Up to five skipped frames with their reasons, and how many there are.
void PrintSkipped(const std::vector<SkippedFrame>& skipped);

}  // namespace cosplat

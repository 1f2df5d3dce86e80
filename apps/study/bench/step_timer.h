// Cost of a training step and its phases.
#pragma once

#include <vector>

#include "apps/study/bench/synthetic_view.h"
#include "splat/render/phase_times.h"
#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct StepTimes {
  double fastest_ms = 0;
  double mean_ms = 0;
  PhaseTimes mean_phases;  // seconds per step
};

// Parts of a step that may be skipped or computed less exactly (TrainSettings).
struct StepShortcuts {
  int exp_degree = kMaxExpDegree;
  AdamOn adam_on = AdamOn::kDrawn;
};

// Gathers the statistics for density control, as in most steps of a run, without acting on them; no
// opacity resets.
TrainSettings SteadySettings(int degree);

// Trains `first` on `frames` at full degree, without density control or opacity resets: `warm_up`
// untimed steps, then `steps` (at least 1) timed ones.
StepTimes TimeSteps(std::vector<TrainFrame> frames,
                    const Gaussians& first,
                    int warm_up,
                    int steps,
                    const StepShortcuts& shortcuts = {});
StepTimes TimeSteps(const SyntheticView& view, int warm_up, int steps);

}  // namespace cosplat

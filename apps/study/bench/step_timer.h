// What a training step and its phases cost.
#pragma once

#include <vector>

#include "apps/study/bench/synthetic_view.h"
#include "splat/render/phase_times.h"
#include "splat/train/scene_subject.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct StepTimes {
  double fastest_ms = 0;
  double mean_ms = 0;
  PhaseTimes mean_phases;  // seconds per step
};

// What a step may leave out or do less exactly (TrainSettings).
struct StepShortcuts {
  int exp_degree = kMaxExpDegree;
  AdamOn adam_on = AdamOn::kDrawn;
};

// Statistics for density control are gathered, as in most steps of a run, and not acted upon; no
// resets.
TrainSettings SteadySettings(int degree);

// Trains `first` on `frames` at their full degree, without density control and without resets:
// `warm_up` steps that are not counted, then `steps` (at least 1) that are.
StepTimes TimeSteps(std::vector<TrainFrame> frames,
                    const Gaussians& first,
                    int warm_up,
                    int steps,
                    const StepShortcuts& shortcuts = {});
StepTimes TimeSteps(const SyntheticView& view, int warm_up, int steps);

}  // namespace cosplat

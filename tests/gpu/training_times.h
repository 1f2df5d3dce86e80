// What the training loop takes for a step, and for a round of density control, here and there.
#pragma once

#include <cstdio>

#include "apps/study/bench/synthetic_view.h"

namespace cosplat::test {

struct TrainingTimes {
  double step_ms = 0;     // of the loop without density control, mean
  double density_ms = 0;  // of one round: clone, split, remove, Morton order
  size_t gaussians = 0;   // after it
};

struct TrainingComparison {
  TrainingTimes any_order, fixed_order, cpu;
};

// Of `steps` steps after as many that are not counted; of two on the CPU.
TrainingComparison CompareTraining(const SyntheticView& view, int steps);

// As a field "training" of the object that is being written.
void WriteJson(std::FILE* file, const TrainingComparison& training);

}  // namespace cosplat::test

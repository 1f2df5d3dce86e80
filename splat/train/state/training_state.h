// What a training run consists of.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/base/rng.h"
#include "splat/gaussians.h"
#include "splat/train/loss/photograph.h"
#include "splat/train/optimize/optimizer.h"
#include "splat/train/state/density_statistics.h"

namespace cosplat {

// The complete state of a run, except its subject's own state (AvatarTrainingState) and what a
// pruning rule learns: with them it is an exact checkpoint (Trainer::Serialize). Until the last
// iteration, updates that `adam` has deferred may be pending for Gaussians that were not visible
// lately. Of several ranks each has its share of the Gaussians, with their moments and statistics
// (splat/train/ranks/row_share.h).
struct TrainingState {
  Gaussians gaussians;
  AdamState adam;
  DensityStatistics statistics;
  Rng rng;
  int iteration = 0;
  std::vector<uint32_t> frames_left;  // rest of the current pass; the next one is at the back
  ExposureState exposures;            // empty unless TrainSettings::exposure
};

}  // namespace cosplat

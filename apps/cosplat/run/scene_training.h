// Trains a static scene into a run folder: what `train-scene` does, and `scene` once there are
// cameras.
#pragma once

#include <memory>
#include <string>

#include "apps/cosplat/options/scene_options.h"
#include "splat/train/ranks/ranks.h"

namespace cosplat {

// Reads o.source, trains, and writes the run folder o.model (run_folder.h). `config`: of ConfigOf.
// Prints what it reads and reaches, unless quiet. Resumes an interrupted run, and leaves a finished
// one as it is, where the options say so. Throws Error before anything is written if the data or
// the options cannot be used; Stopped as RunTraining does. ranks: with whom it trains; rank 0 alone
// writes and prints.
void TrainScene(SceneTrainOptions o,
                const std::string& config,
                std::shared_ptr<Ranks> ranks = OneRank());

}  // namespace cosplat

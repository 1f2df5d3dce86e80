// What `train-scene` makes of its options and a scene before the first step; the benchmark of a
// device begins with the same (tests/gpu).
#pragma once

#include "apps/cosplat/options/train_options.h"
#include "splat/train/scene_subject.h"

namespace cosplat {

struct SceneStart {
  TrainSettings settings;
  Gaussians first;
};

// Settles the background. The scene's points become those that its Gaussians begin at, no more than
// the choices allow. Where it has none, they are `random_points` random ones or, where that is 0,
// as the preset says: found in the images (splat/train/initialize.h), or 3DGS's 100,000 random
// ones.
SceneStart StartScene(size_t random_points, TrainOptions& choices, TrainingScene& scene);

}  // namespace cosplat

// What `train-scene` makes of its options and a scene before the first step; the benchmark of a
// device begins with the same (tests/gpu).
#pragma once

#include "apps/cosplat/train_choices.h"
#include "splat/scene_subject.h"

namespace cosplat {

constexpr size_t kRandomPoints = 100000;  // 3DGS, for scenes without points

struct SceneStart {
  TrainSettings settings;
  Gaussians first;
};

// Settles the background. The scene's points become those that its Gaussians begin at: as many at
// random as `random_points` says where it has none, and no more than the choices allow.
SceneStart StartScene(size_t random_points, TrainChoices& choices, TrainingScene& scene);

}  // namespace cosplat

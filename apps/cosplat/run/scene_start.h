// The state from which `train-scene` starts, derived from its options and the scene; shared with
// the GPU benchmark (tests/gpu).
#pragma once

#include "apps/cosplat/options/train_options.h"
#include "splat/train/subject/scene_subject.h"

namespace cosplat {

struct SceneStart {
  TrainSettings settings;
  Gaussians first;
};

// Resolves the background. Replaces the scene's points by the initial positions of its Gaussians,
// no more than the options allow. A scene without points gets `random_points` random ones or, of
// none, those of the preset: points found in the images (splat/train/start/initialize.h), or
// 3DGS's 100,000 random ones.
SceneStart StartScene(std::optional<size_t> random_points,
                      TrainOptions& choices,
                      TrainingScene& scene);

}  // namespace cosplat

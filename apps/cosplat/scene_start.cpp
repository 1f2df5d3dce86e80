#include "apps/cosplat/scene_start.h"

#include "splat/initialize.h"

namespace cosplat {

SceneStart StartScene(size_t random_points, TrainChoices& o, TrainingScene& scene) {
  o.ResolveBackground(scene.white_background_hint ? "white" : "black");
  if (scene.points.empty()) {
    Rng rng{o.seed};
    std::vector<Camera> cameras;
    for (const TrainFrame& frame : scene.train) cameras.push_back(frame.camera);
    RandomPoints(cameras, random_points, rng, scene.points, scene.point_colors);
  }
  LimitPoints(o.max_gaussians, scene.points, scene.point_colors);
  return {o.ToSettings(scene.extent),
          InitializeFromPoints(
              scene.points, scene.point_colors, o.sh_degree, BasisFromString(o.basis))};
}

}  // namespace cosplat

#include "apps/cosplat/run/scene_start.h"

#include "splat/train/start/initialize.h"

namespace cosplat {
namespace {

constexpr size_t kSweepRays = 40000;
constexpr size_t kRandomPoints = 100000;  // 3DGS

// Returns whether random points were added.
bool FindPoints(std::optional<size_t> random_points, const TrainOptions& o, TrainingScene& scene) {
  Rng rng{o.seed};
  if (!random_points && o.preset == Preset::kCosplat)
    SweepPoints(scene.train, kSweepRays, rng, scene.points, scene.point_colors);
  // Almost nothing was found: too few images, or images without texture.
  if (scene.points.size() / 3 >= kSweepRays / 20) return false;
  std::vector<Camera> cameras;
  for (const TrainFrame& frame : scene.train) cameras.push_back(frame.camera);
  RandomPoints(
      cameras, random_points.value_or(kRandomPoints), rng, scene.points, scene.point_colors);
  return true;
}

}  // namespace

SceneStart StartScene(std::optional<size_t> random_points, TrainOptions& o, TrainingScene& scene) {
  o.renderings = scene.renderings;
  o.ResolveBackground(o.renderings ? Background::kWhite : Background::kBlack);
  const bool random = scene.points.empty() && FindPoints(random_points, o, scene);
  LimitPoints(o.max_gaussians, scene.points, scene.point_colors);
  SceneStart start{
      o.ToSettings(scene.extent),
      InitializeFromPoints(
          scene.points, scene.point_colors, o.sh_degree, o.basis, SmallUnit(scene.extent))};
  // Random points cause floaters in front of the cameras, which only opacity resets remove.
  if (random) start.settings.schedule.opacity_reset_share = 1;
  return start;
}

}  // namespace cosplat

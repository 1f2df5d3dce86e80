// Chooses where a scene's coordinates are counted from, and makes them floats.
#include <algorithm>
#include <cmath>

#include "splat/base/camera.h"
#include "splat/io/view_files.h"

namespace cosplat {
namespace {

template <class Action>
void ForEachView(SceneData& scene, const Action& action) {
  for (std::vector<SceneView>* views : {&scene.train, &scene.test})
    for (SceneView& view : *views) action(view);
}

WorldOrigin ChooseOrigin(SceneData& scene) {
  std::vector<double> centers;
  ForEachView(scene, [&](const SceneView& view) {
    centers.insert(centers.end(), view.center.begin(), view.center.end());
  });
  const Middle cameras = MiddleOf(centers);
  // The points of photographs from one side are farther apart than the cameras.
  return OriginNear(cameras.center, std::max(cameras.spread, MiddleOf(scene.read_points).spread));
}

// From the place in double precision: the translation has lost it. Others keep their bits.
void MoveCamera(const std::array<double, 3>& center, const WorldOrigin& origin, Camera& camera) {
  for (size_t i = 0; i < 3; ++i) {
    double translation = 0;
    for (size_t k = 0; k < 3; ++k)
      translation -= double(camera.rotation[3 * i + k]) * (center[k] - origin[k]);
    camera.translation[i] = float(translation);
  }
}

}  // namespace

void PlaceScene(const std::optional<WorldOrigin>& origin, SceneData& scene) {
  scene.origin = origin ? *origin : ChooseOrigin(scene);
  for (size_t i = 0; i < scene.read_points.size(); ++i)
    scene.points.push_back(float(scene.read_points[i] - scene.origin[i % 3]));
  scene.read_points = {};
  if (scene.origin != WorldOrigin{})
    ForEachView(scene, [&](SceneView& view) {
      for (Camera* camera : {&view.camera, &view.file_camera})
        MoveCamera(view.center, scene.origin, *camera);
    });
  scene.extent = SceneExtent(scene.train);
  const float near_plane = kNearPlane * SmallUnit(scene.extent);
  ForEachView(scene, [&](SceneView& view) {
    view.camera.near_plane = view.file_camera.near_plane = near_plane;
  });
}

}  // namespace cosplat

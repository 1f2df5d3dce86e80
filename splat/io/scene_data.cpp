#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "splat/base/error.h"
#include "splat/io/dataset.h"
#include "splat/io/view_files.h"

namespace cosplat {
namespace {

// 3DGS holds out every 8th view (after mip-NeRF 360).
constexpr size_t kHoldOut = 8;

void HoldOutEvery8th(SceneData& scene) {
  std::vector<SceneView> all = std::move(scene.train);
  scene.train.clear();
  scene.test.clear();
  for (size_t i = 0; i < all.size(); ++i)
    (i % kHoldOut == 0 ? scene.test : scene.train).push_back(std::move(all[i]));
}

void SortByName(std::vector<SceneView>& views) {
  std::stable_sort(views.begin(), views.end(), [](const SceneView& a, const SceneView& b) {
    return a.name < b.name;
  });
}

}  // namespace

SceneData LoadScene(const std::string& path, const SceneOptions& options) {
  if (!std::filesystem::is_directory(path)) throw Error(path, "is not a folder");
  if (options.resolution < 1)
    throw Error("resolution", std::to_string(options.resolution) + " is not positive");
  SceneData scene;
  scene.source = path;
  if (IsColmapScene(path)) {
    LoadColmapScene(path, options, scene);
  } else if (IsBlenderScene(path)) {
    LoadBlenderScene(path, options, scene);
  } else if (IsNerfstudioScene(path)) {
    LoadNerfstudioScene(path, options, scene);
  } else {
    throw Error(path,
                "contains no scene: expected sparse/ (COLMAP), transforms_train.json or "
                "transforms.json");
  }
  CheckSkipped(path, scene.train.size() + scene.test.size(), scene.skipped);
  const bool own_split = scene.layout == "blender";  // its order is also kept
  if (!own_split) SortByName(scene.train);
  if (!own_split && (options.eval || options.fold)) HoldOutEvery8th(scene);
  if (own_split && !options.eval && !options.fold) {  // as 3DGS: trains on all views
    std::move(scene.test.begin(), scene.test.end(), std::back_inserter(scene.train));
    scene.test.clear();
  }
  if (options.fold) HoldOutEvery8th(scene);
  if (scene.train.empty())
    throw Error(path,
                "has no training views: all " + std::to_string(scene.test.size()) +
                    " views are in the test set");
  scene.extent = SceneExtent(scene.train);
  return scene;
}

float SceneExtent(const std::vector<SceneView>& views) {
  std::array<double, 3> mean{};
  for (const SceneView& view : views)
    for (int k = 0; k < 3; ++k) mean[k] += double(view.camera.Center()[k]) / views.size();
  double greatest = 0;
  for (const SceneView& view : views) {
    const std::array<float, 3> c = view.camera.Center();
    greatest = std::max(greatest, std::hypot(c[0] - mean[0], c[1] - mean[1], c[2] - mean[2]));
  }
  return greatest > 1e-6 ? float(1.1 * greatest) : 1;
}

}  // namespace cosplat

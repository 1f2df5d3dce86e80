#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>

#include "splat/base/error.h"
#include "splat/base/text.h"
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

// masks/NAME.png and masks/STEM.png, of views that name no mask of their own.
void FindMasks(const std::string& path, std::vector<SceneView>& views) {
  const std::filesystem::path folder = std::filesystem::path(path) / "masks";
  if (!std::filesystem::is_directory(folder)) return;
  for (SceneView& view : views) {
    if (!view.mask_path.empty()) continue;
    const std::filesystem::path name = std::filesystem::path(view.name);
    std::filesystem::path stem = name;
    stem.replace_extension(".png");
    for (const std::filesystem::path& file : {folder / (name.string() + ".png"), folder / stem})
      if (view.mask_path.empty() && std::filesystem::is_regular_file(file))
        view.mask_path = file.string();
  }
}

// Two names that lead to one file: a folder of the data set is missing, and the end of the names
// alone is not enough.
void RefuseSharedImages(const SceneData& scene) {
  std::map<std::string, std::string> names;
  for (const auto* views : {&scene.train, &scene.test})
    for (const SceneView& view : *views) {
      const auto [found, is_new] = names.emplace(view.image_path, view.name);
      if (!is_new && found->second != view.name)
        throw Error(scene.source,
                    view.name,
                    "and " + found->second + " are both found as " + view.image_path +
                        " only: a folder of images is missing");
    }
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
  for (std::vector<SceneView>* views : {&scene.train, &scene.test}) FindMasks(path, *views);
  FindPoints({path + "/points3D.ply", path + "/points3d.ply", path + "/sparse_pc.ply"}, scene);
  RefuseSharedImages(scene);
  if (scene.layout != "blender") SortByName(scene.train);  // whose order is kept
  const bool own_split = scene.own_split;
  if (!own_split && (options.eval || options.fold)) HoldOutEvery8th(scene);
  if (scene.layout == "blender" && !own_split && options.eval)
    scene.notes.push_back(
        "there is no transforms_test.json: every 8th view of transforms_train.json is the test "
        "set");
  if (own_split && !options.eval && !options.fold) {  // as 3DGS: trains on all views
    std::move(scene.test.begin(), scene.test.end(), std::back_inserter(scene.train));
    scene.test.clear();
  }
  if (options.fold) HoldOutEvery8th(scene);
  if (scene.train.empty())
    throw Error(
        path, Format("has no training views: all {} views are in the test set", scene.test.size()));
  PlaceScene(options.origin, scene);
  SettleHalfTurns(scene);
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

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

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

// Those folders of `path` whose name begins with "mask", in whatever case: "masks" first.
std::vector<std::filesystem::path> MaskFolders(const std::string& path) {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(path))
    if (entry.is_directory() && LowerCase(entry.path().filename().string()).starts_with("mask"))
      folders.push_back(entry.path());
  const auto rank = [](const std::filesystem::path& folder) {
    const std::string name = folder.filename().string();
    return std::tuple(LowerCase(name) != "masks", name.size(), name);
  };
  std::sort(folders.begin(), folders.end(), [&](const auto& a, const auto& b) {
    return rank(a) < rank(b);
  });
  return folders;
}

// masks/NAME.png, masks/STEM.png and masks/STEM_mask.png, of any image ending, for views that name
// no mask of their own; masks_2 and so on where there is no masks.
void FindMasks(SceneData& scene) {
  const std::vector<std::filesystem::path> folders = MaskFolders(scene.source);
  const auto is_read = [](const std::filesystem::path& folder) {
    return LowerCase(folder.filename().string()).starts_with("masks");
  };
  size_t all = 0, masked = 0;
  std::map<std::string, std::vector<SceneView*>> found;
  DataFiles files(folders.empty() ? scene.source : folders.front().string());
  for (auto* views : {&scene.train, &scene.test})
    for (SceneView& view : *views) {
      const std::string stem =
          std::filesystem::path(view.name).replace_extension().generic_string();
      const bool looks = view.mask_path.empty() && !folders.empty() && is_read(folders.front());
      for (const std::string& name : {view.name + ".png", view.name, stem + "_mask.png"})
        if (looks && view.mask_path.empty()) view.mask_path = files.FindImage(name);
      if (looks && !view.mask_path.empty()) found[view.mask_path].push_back(&view);
      ++all, masked += !view.mask_path.empty();
    }
  for (const auto& [file, views] : found) {
    if (views[0]->name == views.back()->name) continue;
    scene.notes.push_back(file + " is not used: it would be of " + views[0]->name + " and " +
                          views.back()->name + ", whose folders masks/ does not have");
    for (SceneView* view : views) view->mask_path.clear(), --masked;
  }
  if (masked > 0 && masked < all)
    scene.notes.push_back(Format("{} of {} views have masks", masked, all));
  if (masked == 0 && found.empty() && !folders.empty())
    scene.notes.push_back(folders.front().string() +
                          (is_read(folders.front())
                               ? " has no file named after a view, as masks/NAME.png is"
                               : " is not read: masks/NAME.png is, black where NAME is ignored"));
}

size_t PartsOf(const std::string& name) {
  const std::filesystem::path path(name);
  return size_t(std::distance(path.begin(), path.end()));
}

// Photographs beside those that have a camera, which structure from motion could not place.
void NoteImagesWithoutCamera(SceneData& scene) {
  std::set<std::string> folders, used, roots;  // images and reduced ones have two roots
  for (const auto* views : {&scene.train, &scene.test})
    for (const SceneView& view : *views) {
      const std::filesystem::path file(view.image_path);
      std::filesystem::path root = file.parent_path();
      for (size_t i = 1; i < PartsOf(view.name); ++i) root = root.parent_path();
      roots.insert(root.string());
      used.insert(file.lexically_normal().string());
      folders.insert(file.parent_path().string());
    }
  if (roots.size() > 1) return;
  size_t all = 0, without = 0;
  std::string first;
  for (const std::string& folder : folders)
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (!IsImageName(entry.path().string())) continue;
      ++all;
      const std::string file = entry.path().lexically_normal().string();
      if (used.contains(file)) continue;
      if (without++ == 0 || file < first) first = file;
    }
  if (without > scene.skipped.size())
    scene.notes.push_back(
        Format("{} of {} images have no camera and are not used (first: {})", without, all, first));
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
  FindMasks(scene);
  if (scene.layout == "colmap") NoteImagesWithoutCamera(scene);
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

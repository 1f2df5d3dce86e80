#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/io/colmap_model.h"
#include "splat/io/view_files.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// 3x3 rotation of a quaternion of any norm; all NaN if the norm is zero or not finite.
std::array<double, 9> RotationMatrix(const std::array<double, 4>& q) {
  const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
  return {1 - 2 * (y * y + z * z),
          2 * (x * y - w * z),
          2 * (x * z + w * y),
          2 * (x * y + w * z),
          1 - 2 * (x * x + z * z),
          2 * (y * z - w * x),
          2 * (x * z - w * y),
          2 * (y * z + w * x),
          1 - 2 * (x * x + y * y)};
}

// nerfstudio keeps COLMAP's model in colmap/, beside a transforms.json that comes first.
std::string SparseFolder(const std::string& path) {
  if (fs::is_directory(path + "/sparse")) return path + "/sparse";
  const std::string kept = path + "/colmap/sparse";
  return fs::is_directory(kept) && !fs::exists(path + "/transforms.json") ? kept : "";
}

// For example "has no folder images; found images_8: use -r 8".
std::string MissingFolderProblem(const std::string& path, const SceneOptions& options) {
  std::string text = "has no folder " + options.images;
  if (options.resolution > 1) text += Format(" or {}_{}", options.images, options.resolution);
  std::string found;
  for (const auto& entry : fs::directory_iterator(path)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory() && name.starts_with("images_"))
      found += "; found " + name + ": use -r " + name.substr(7);
  }
  return text + found;
}

bool HasImageFolder(const std::string& path, const SceneOptions& options) {
  const std::string folder = path + "/" + options.images;
  if (fs::is_directory(folder)) return true;
  for (int k = 2; k <= options.resolution; ++k)
    if (options.resolution % k == 0 && fs::is_directory(Format("{}_{}", folder, k))) return true;
  return false;
}

// COLMAP writes what it cannot join as models of their own: sparse/0, sparse/1, ... Some tools put
// the only one into sparse/ itself.
ColmapModel LargestModel(const std::string& sparse, SceneData& scene) {
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(sparse))
    if (fs::exists(entry.path() / "cameras.bin") || fs::exists(entry.path() / "cameras.txt"))
      folders.push_back(entry.path().string());
  if (folders.empty())
    return ReadColmapModel(fs::is_directory(sparse + "/0") ? sparse + "/0" : sparse);
  std::sort(folders.begin(), folders.end());
  ColmapModel largest;
  std::string chosen, all;
  for (const std::string& folder : folders) {
    ColmapModel model = ReadColmapModel(folder);
    all += (all.empty() ? "" : ", ") + fs::path(folder).filename().string() + " " +
           std::to_string(model.images.size());
    if (!chosen.empty() && model.images.size() <= largest.images.size()) continue;
    largest = std::move(model);
    chosen = folder;
  }
  if (folders.size() > 1)
    scene.notes.push_back(chosen + " is used, which has the most images of the models there (" +
                          all + ")");
  return largest;
}

}  // namespace

bool IsColmapScene(const std::string& path) { return !SparseFolder(path).empty(); }

void LoadColmapScene(const std::string& path, const SceneOptions& options, SceneData& scene) {
  scene.layout = "colmap";
  ColmapModel model = LargestModel(SparseFolder(path), scene);
  if (model.images.empty()) throw Error(model.images_file, "contains no images");
  scene.notes.insert(scene.notes.end(), model.notes.begin(), model.notes.end());
  scene.read_points = std::move(model.points);
  scene.point_colors = std::move(model.point_colors);
  FindPoints({fs::path(model.images_file).parent_path().string() + "/points3D.ply"}, scene);
  if (!HasImageFolder(path, options)) throw Error(path, MissingFolderProblem(path, options));
  DataFiles files(path);
  size_t elsewhere = 0;
  for (const ColmapImage& image : model.images) {
    SceneView view;
    view.name = image.name;
    const ColmapCamera& camera = model.cameras.at(image.camera_id);
    view.distortion = camera.distortion;
    std::string problem =
        SetPose(RotationMatrix(image.rotation), image.translation, view.camera, &view.center);
    const FoundImage found =
        FindInFolder(files, options.images, ForwardSlashes(image.name), options.resolution);
    view.image_path = found.path;
    elsewhere += found.elsewhere;
    if (problem.empty() && found.path.empty())
      problem = "image " + path + "/" + found.tried + " is missing";
    if (problem.empty()) problem = Problem([&] { FinishView(camera.lens, found.divide_by, view); });
    if (problem.empty())
      scene.train.push_back(std::move(view));
    else
      scene.skipped.push_back({image.name, problem});
  }
  NoteElsewhere(elsewhere, options.resolution, scene);
}

}  // namespace cosplat

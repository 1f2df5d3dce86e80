#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splat/base/camera.h"
#include "splat/base/error.h"
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

// For example "has no folder images; found images_8: use -r 8".
std::string MissingFolderProblem(const std::string& path, int resolution) {
  std::string text = "has no folder images";
  if (resolution > 1) text += " or images_" + std::to_string(resolution);
  std::string found;
  for (const auto& entry : fs::directory_iterator(path)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory() && name.starts_with("images_"))
      found += "; found " + name + ": use -r " + name.substr(7);
  }
  return text + found;
}

}  // namespace

bool IsColmapScene(const std::string& path) { return fs::is_directory(path + "/sparse"); }

void LoadColmapScene(const std::string& path, const SceneOptions& options, SceneData& scene) {
  scene.layout = "colmap";
  const std::string numbered = path + "/sparse/0";
  ColmapModel model = ReadColmapModel(fs::is_directory(numbered) ? numbered : path + "/sparse");
  if (model.images.empty()) throw Error(model.images_file, "contains no images");
  scene.read_points = std::move(model.points);
  scene.point_colors = std::move(model.point_colors);
  const FoundImage any = FindImage(path + "/images", model.images[0].name, options.resolution);
  if (!any.folder_exists) throw Error(path, MissingFolderProblem(path, options.resolution));
  for (const ColmapImage& image : model.images) {
    SceneView view;
    view.name = image.name;
    const ColmapCamera& camera = model.cameras.at(image.camera_id);
    view.distortion = camera.distortion;
    const PoseProblem problem =
        SetPose(RotationMatrix(image.rotation), image.translation, view.camera, &view.center);
    const FoundImage found = FindImage(path + "/images", image.name, options.resolution);
    view.image_path = found.path;
    if (!problem.empty()) {
      scene.skipped.push_back({image.name, problem});
    } else if (found.path.empty()) {
      scene.skipped.push_back({image.name, "image " + found.tried + " is missing"});
    } else {
      const std::string unusable = Problem([&] { FinishView(camera.lens, found.divide_by, view); });
      if (unusable.empty()) {
        scene.train.push_back(std::move(view));
      } else {
        scene.skipped.push_back({image.name, unusable});
      }
    }
  }
}

}  // namespace cosplat

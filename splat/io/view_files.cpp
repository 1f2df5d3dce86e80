#include "splat/io/view_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/io/ply.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// Rays from the principal point to the border, with `kSteps` consecutive points on each.
constexpr int kSteps = 12;
constexpr int kRaysPerSide = 24;

std::vector<std::array<double, 2>> BorderRays(const Camera& target) {
  std::vector<std::array<double, 2>> points;
  const auto add = [&](double x, double y) {
    for (int s = 1; s <= kSteps; ++s) {
      const double t = double(s) / kSteps;
      points.push_back({target.cx + t * (x - target.cx), target.cy + t * (y - target.cy)});
    }
  };
  for (int i = 0; i <= kRaysPerSide; ++i) {
    const double x = double(i) * target.width / kRaysPerSide;
    const double y = double(i) * target.height / kRaysPerSide;
    add(x, 0);
    add(x, target.height);
    add(0, y);
    add(target.width, y);
  }
  return points;
}

// Whether every border pixel of `target` lies inside the distorted image. Radii must grow along
// each ray: a distortion polynomial folds back outside the range for which it was fitted, and
// points that fold back into the image do not show it.
bool CoversBorder(const Camera& lens, const Distortion& distortion, const Camera& target) {
  const auto points = DistortedPixels(lens, distortion, target, BorderRays(target));
  double last_radius = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto [x, y] = points[i];
    const double radius = std::hypot(x - lens.cx, y - lens.cy);
    if (i % kSteps != 0 && !(radius > last_radius)) return false;
    last_radius = radius;
    // Allows a hundredth of a pixel for rounding.
    if (!(x >= -0.01 && y >= -0.01 && x <= lens.width + 0.01 && y <= lens.height + 0.01))
      return false;
  }
  return true;
}

}  // namespace

namespace {

// To a pixel, at the height or the width of the image.
bool Fits(const ImageInfo& image, const Camera& lens) {
  const double width = double(lens.width) * image.height / lens.height;
  const double height = double(lens.height) * image.width / lens.width;
  return std::abs(width - image.width) <= 1 || std::abs(height - image.height) <= 1;
}

}  // namespace

FoundImage FindInFolder(DataFiles& files,
                        const std::string& folder,
                        const std::string& name,
                        int resolution) {
  const auto reduced = [&](int k) {
    return (k == 1 ? folder : folder + "_" + std::to_string(k)) + "/" + name;
  };
  FoundImage found;
  found.tried = reduced(1);
  std::vector<int> candidates{resolution};
  if (resolution > 1) candidates.push_back(1);
  for (int k = resolution - 1; k > 1; --k)
    if (resolution % k == 0) candidates.push_back(k);
  // An end of the name that has lost the reduced folder would be the full-size image.
  const auto is_reduced = [&](const std::string& path, int k) {
    const std::string name = fs::path(folder).filename().string() + "_" + std::to_string(k);
    return path.find("/" + name + "/") != std::string::npos;
  };
  for (int k : candidates) {
    found.path = files.FindImage(reduced(k));
    found.divide_by = resolution / k;
    if (k > 1 && !is_reduced(found.path, k)) found.path.clear();
    if (!found.path.empty()) break;
  }
  if (found.path.empty() || found.divide_by == 1 || found.divide_by < resolution) return found;
  const std::string full = fs::path(found.path).string();
  const std::string above = full.substr(0, full.size() - std::min(full.size(), name.size() + 1));
  found.elsewhere = fs::is_directory(above + "_" + std::to_string(resolution));
  return found;
}

FoundImage FindImage(DataFiles& files, const std::string& named, int resolution) {
  const fs::path path(ForwardSlashes(named));
  // Images next to the file that names them have no folder that could have reduced copies.
  if (path.has_parent_path() && path.parent_path() != ".")
    return FindInFolder(files, path.parent_path().string(), path.filename().string(), resolution);
  return {files.FindImage(named), resolution, named, false};
}

void FindPoints(const std::vector<std::string>& files, SceneData& scene) {
  for (const std::string& file : files) {
    if (!scene.read_points.empty() || !fs::is_regular_file(file)) continue;
    scene.coarse_points = !ReadPointsPly(file, scene.read_points, scene.point_colors);
    scene.notes.push_back("the points are those of " + file);
  }
}

void NoteElsewhere(size_t count, int resolution, SceneData& scene) {
  if (count == 0) return;
  scene.notes.push_back(std::to_string(count) + " images are not in the folder of images at 1/" +
                        std::to_string(resolution) + ": they are made from the full-size ones");
}

Camera PinholeInside(const std::string& file, const Camera& lens, const Distortion& distortion) {
  if (distortion.model == Distortion::Model::kNone) return lens;
  const auto zoomed = [&](double zoom) {
    Camera c = lens;
    c.fx = float(lens.fx * zoom);
    c.fy = float(lens.fy * zoom);
    return c;
  };
  const double side_x = std::max(lens.cx, lens.width - lens.cx);
  const double side_y = std::max(lens.cy, lens.height - lens.cy);
  constexpr double kMaxTangent = 2;
  double low = std::max(side_x / lens.fx, side_y / lens.fy) / kMaxTangent;
  double high = std::max(8.0, 2 * low);
  if (CoversBorder(lens, distortion, zoomed(low))) return zoomed(low);
  if (!CoversBorder(lens, distortion, zoomed(high)))
    throw Error(file, "distortion", "leaves no part of the image that a pinhole camera could show");
  while (high - low > 1e-4 * high) {
    const double middle = (low + high) / 2;
    (CoversBorder(lens, distortion, zoomed(middle)) ? high : low) = middle;
  }
  return zoomed(high);
}

void FinishView(const Camera& lens, int divide_by, SceneView& view) {
  // As it is stored if that fits its camera, as structure from motion reads it and as a tag is that
  // was left on turned pixels; else as viewers show it. Half turns: SettleHalfTurns.
  const ImageInfo stored = ReadImageInfo(view.image_path);
  ImageInfo info = stored;
  if (!Fits(stored, lens) && Fits(stored.Upright(), lens)) {
    info = stored.Upright();
    view.orientation = stored.orientation;
  } else if (Fits(stored.Upright(), lens)) {
    view.tag = stored.orientation;
  }
  if (!Fits(info, lens))
    throw Error(view.image_path,
                "image is " + SizeText(info.width, info.height) + ", its camera " +
                    SizeText(lens.width, lens.height) + ": the proportions differ");
  const Camera pose = view.camera;
  view.file_camera = lens.Resized(info.width, info.height);
  view.file_camera.rotation = pose.rotation;
  view.file_camera.translation = pose.translation;
  const Camera pinhole = PinholeInside(view.image_path, view.file_camera, view.distortion);
  view.camera = pinhole.Resized(std::max(1, int(std::lround(double(info.width) / divide_by))),
                                std::max(1, int(std::lround(double(info.height) / divide_by))));
}

}  // namespace cosplat

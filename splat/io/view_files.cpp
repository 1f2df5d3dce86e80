#include "splat/io/view_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "splat/base/error.h"

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

FoundImage FindImage(const std::string& folder, const std::string& name, int resolution) {
  const auto reduced = [&](int k) { return k == 1 ? folder : folder + "_" + std::to_string(k); };
  FoundImage found;
  std::vector<int> candidates{resolution, 1};
  for (int k = resolution - 1; k > 1; --k)
    if (resolution % k == 0) candidates.push_back(k);
  for (int k : candidates) {
    if (!fs::is_directory(reduced(k))) continue;
    found.folder_exists = true;
    found.tried = reduced(k) + "/" + name;
    found.divide_by = resolution / k;
    if (fs::is_regular_file(found.tried)) found.path = found.tried;
    return found;
  }
  found.tried = folder + "/" + name;
  return found;
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
  const ImageInfo info = ReadImageInfo(view.image_path);
  const double expected_width = double(lens.width) * info.height / lens.height;
  const double expected_height = double(lens.height) * info.width / lens.width;
  if (std::abs(expected_width - info.width) > 1 && std::abs(expected_height - info.height) > 1)
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

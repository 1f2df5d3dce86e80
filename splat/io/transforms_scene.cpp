#include <cmath>
#include <filesystem>
#include <numbers>

#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/io/ply.h"
#include "splat/io/view_files.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The fields of a frame, which override those of the file.
class FrameFields {
 public:
  FrameFields(const JsonField& file, const JsonField& frame) : file_(file), frame_(frame) {}
  bool Has(const std::string& key) const { return frame_.Has(key) || file_.Has(key); }
  JsonField Get(const std::string& key) const { return frame_.Has(key) ? frame_[key] : file_[key]; }
  double NumberOr(const std::string& key, double fallback) const {
    return Has(key) ? Get(key).Number() : fallback;
  }

 private:
  JsonField file_, frame_;
};

double FocalFromAngle(const JsonField& angle, double side) {
  const double value = angle.Number();
  if (!(value > 0 && value < std::numbers::pi))
    throw Error(angle.file(), angle.path(), std::to_string(value) + " is not in (0, pi)");
  return side / 2 / std::tan(value / 2);
}

// Intrinsics at the size given by w and h, or otherwise that of `info`.
Camera LensOf(const FrameFields& fields, const ImageInfo& info) {
  Camera lens;
  lens.width = fields.Has("w") ? fields.Get("w").Integer() : info.width;
  lens.height = fields.Has("h") ? fields.Get("h").Integer() : info.height;
  for (const char* key : {"w", "h"}) {
    if (!fields.Has(key)) continue;
    const JsonField side = fields.Get(key);
    if (side.Integer() < 1) throw Error(side.file(), side.path(), "is not positive");
  }
  if (fields.Has("fl_x")) {
    lens.fx = float(fields.Get("fl_x").Number());
  } else {
    lens.fx = float(FocalFromAngle(fields.Get("camera_angle_x"), lens.width));
  }
  lens.fy = lens.fx;
  if (fields.Has("fl_y")) {
    lens.fy = float(fields.Get("fl_y").Number());
  } else if (!fields.Has("fl_x") && fields.Has("camera_angle_y")) {
    lens.fy = float(FocalFromAngle(fields.Get("camera_angle_y"), lens.height));
  }
  for (const char* key : {"fl_x", "fl_y"})
    if (fields.Has(key) && !(fields.Get(key).Number() > 0))
      throw Error(fields.Get(key).file(), fields.Get(key).path(), "is not positive");
  lens.cx = float(fields.NumberOr("cx", lens.width / 2.0));
  lens.cy = float(fields.NumberOr("cy", lens.height / 2.0));
  return lens;
}

bool IsFisheye(const FrameFields& fields) {
  if (fields.Has("is_fisheye")) {
    const JsonField flag = fields.Get("is_fisheye");
    if (!flag.raw().is_boolean()) throw Error(flag.file(), flag.path(), "expected true or false");
    if (flag.raw().get<bool>()) return true;
  }
  if (!fields.Has("camera_model")) return false;
  const JsonField model = fields.Get("camera_model");
  const std::string name = model.String();
  if (name == "OPENCV_FISHEYE") return true;
  if (name == "OPENCV" || name == "PINHOLE" || name == "SIMPLE_PINHOLE" ||
      name == "SIMPLE_RADIAL" || name == "RADIAL" || name == "PERSPECTIVE")
    return false;
  throw Error(model.file(), model.path(), "camera model " + name + " cannot be undistorted");
}

Distortion DistortionOf(const FrameFields& fields) {
  Distortion distortion;
  const auto k = [&](const char* key) { return fields.NumberOr(key, 0); };
  if (IsFisheye(fields)) {
    distortion.model = Distortion::Model::kFisheye;
    int i = 0;
    for (const char* key : {"k1", "k2", "k3", "k4"}) distortion.k[i++] = k(key);
    return distortion;
  }
  if (k("k4") != 0) {
    const JsonField field = fields.Get("k4");
    throw Error(field.file(), field.path(), "an eighth-order radial term cannot be undistorted");
  }
  int i = 0;
  for (const char* key : {"k1", "k2", "p1", "p2", "k3"}) {
    distortion.k[i++] = k(key);
    if (k(key) != 0) distortion.model = Distortion::Model::kBrown;
  }
  return distortion;
}

// "./train/r_0" -> "train/r_0.png", since Blender's files omit the extension.
fs::path ImageName(const std::string& file_path) {
  fs::path name = fs::path(file_path).lexically_normal();
  if (!name.has_extension()) name += ".png";
  return name;
}

FoundImage FindFrameImage(const fs::path& folder, const fs::path& name, int resolution) {
  // Images next to the JSON file have no folder of their own that could have reduced copies.
  const bool has_folder = name.has_parent_path();
  FoundImage found = FindImage((folder / name.parent_path()).string(),
                               name.filename().string(),
                               has_folder ? resolution : 1);
  if (!has_folder) found.divide_by = resolution;
  return found;
}

PoseProblem SetFramePose(const JsonField& field, SceneView& view) {
  const std::vector<double> values = field.NumbersOrNan();
  if (values.size() != 16 && values.size() != 12)
    throw Error(field.file(),
                field.path(),
                "found " + std::to_string(values.size()) + " numbers, expected a 4x4 matrix");
  std::array<double, 12> matrix;
  std::copy(values.begin(), values.begin() + 12, matrix.begin());
  return SetPoseFromOpenGlWorldFromCam(matrix, view.camera, &view.center);
}

// The points that a file of cameras names, if it does.
void LoadPoints(const JsonField& file, SceneData& scene) {
  if (!file.Has("ply_file_path")) return;
  const fs::path folder = fs::path(file.file()).parent_path();
  scene.coarse_points = !ReadPointsPly(
      (folder / file["ply_file_path"].String()).string(), scene.read_points, scene.point_colors);
}

// Adds the frames of one file to `views`, or to `skipped`.
void LoadFrames(const JsonField& file,
                const SceneOptions& options,
                std::vector<SceneView>& views,
                std::vector<SkippedFrame>& skipped) {
  const fs::path folder = fs::path(file.file()).parent_path();
  const JsonField frames = file["frames"];
  for (size_t i = 0; i < frames.size(); ++i) {
    const JsonField frame = frames[i];
    const FrameFields fields(file, frame);
    const fs::path name = ImageName(frame["file_path"].String());
    SceneView view;
    view.name = name.generic_string();
    const PoseProblem problem = SetFramePose(frame["transform_matrix"], view);
    const FoundImage found = FindFrameImage(folder, name, options.resolution);
    view.image_path = found.path;
    if (frame.Has("mask_path")) view.mask_path = (folder / frame["mask_path"].String()).string();
    if (!problem.empty()) {
      skipped.push_back({view.name, problem});
    } else if (found.path.empty()) {
      skipped.push_back({view.name, "image " + found.tried + " is missing"});
    } else if (!view.mask_path.empty() && !fs::is_regular_file(view.mask_path)) {
      skipped.push_back({view.name, "mask " + view.mask_path + " is missing"});
    } else {
      // Without w and h the intrinsics belong to the full-size image.
      const fs::path full = folder / name;
      view.distortion = DistortionOf(fields);
      const std::string sized = fs::is_regular_file(full) ? full.string() : found.path;
      ImageInfo info;
      std::string unusable = Problem([&] { info = ReadImageInfo(sized); });
      if (unusable.empty()) {
        const Camera lens = LensOf(fields, info);  // missing fields fail the whole file
        unusable = Problem([&] { FinishView(lens, found.divide_by, view); });
      }
      if (unusable.empty()) {
        views.push_back(std::move(view));
      } else {
        skipped.push_back({view.name, unusable});
      }
    }
  }
}

}  // namespace

bool IsBlenderScene(const std::string& path) {
  return fs::is_regular_file(path + "/transforms_train.json");
}

void LoadBlenderScene(const std::string& path, const SceneOptions& options, SceneData& scene) {
  scene.layout = "blender";
  for (const char* split : {"train", "test"}) {
    const std::string file = path + "/transforms_" + split + ".json";
    const bool train = split == std::string("train");
    if (!train && !fs::exists(file)) continue;
    const Json json = ReadJson(file);
    LoadFrames(JsonField(file, json), options, train ? scene.train : scene.test, scene.skipped);
    if (train) LoadPoints(JsonField(file, json), scene);
  }
  scene.white_background_hint =
      !scene.train.empty() && ReadImageInfo(scene.train[0].image_path).channels == 4;
}

bool IsNerfstudioScene(const std::string& path) {
  return fs::is_regular_file(path + "/transforms.json");
}

void LoadNerfstudioScene(const std::string& path, const SceneOptions& options, SceneData& scene) {
  scene.layout = "nerfstudio";
  const std::string path_of_json = path + "/transforms.json";
  const Json json = ReadJson(path_of_json);
  const JsonField file(path_of_json, json);
  LoadFrames(file, options, scene.train, scene.skipped);
  LoadPoints(file, scene);
}

}  // namespace cosplat

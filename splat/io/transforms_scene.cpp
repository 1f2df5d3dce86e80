#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <numbers>
#include <set>

#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/io/ply.h"
#include "splat/io/view_files.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The fields of a frame, which override those of the file. A frame that states a focal length by
// one kind of field (fl_x or camera_angle_x) overrides the file's of the other kind, too.
class FrameFields {
 public:
  FrameFields(const JsonField& file, const JsonField& frame) : file_(file), frame_(frame) {}
  bool Has(const std::string& key) const {
    if (frame_.Has(key)) return true;
    if (key.starts_with("fl_") && frame_.Has("camera_angle_x")) return false;
    if (key.starts_with("camera_angle_") && frame_.Has("fl_x")) return false;
    return file_.Has(key);
  }
  JsonField Get(const std::string& key) const { return frame_.Has(key) ? frame_[key] : file_[key]; }
  // Whether the frame has it itself.
  bool IsOwn(const std::string& key) const { return frame_.Has(key); }
  double NumberOr(const std::string& key, double fallback) const {
    return Has(key) ? Get(key).Number() : fallback;
  }
  // A length in pixels along `side` (w or h). The file's is for the file's size, which a frame's
  // own may differ from.
  double Pixels(const std::string& key, const std::string& side) const {
    const double number = Get(key).Number();
    if (frame_.Has(key) || !frame_.Has(side) || !file_.Has(side)) return number;
    return number * frame_[side].Number() / file_[side].Number();
  }

 private:
  JsonField file_, frame_;
};

double FocalFromAngle(const JsonField& angle, double side) {
  const double value = angle.Number();
  if (!(value > 0 && value < std::numbers::pi)) angle.Fail(Format("{} is not in (0, pi)", value));
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
    if (side.Integer() < 1) side.Fail("is not positive");
  }
  // One of the two focal lengths is both where the other is not stated.
  const auto focal = [&](const std::string& axis, const std::string& side, double length) -> float {
    if (fields.Has("fl_" + axis)) return float(fields.Pixels("fl_" + axis, side));
    if (!fields.Has("camera_angle_" + axis)) return 0;
    return float(FocalFromAngle(fields.Get("camera_angle_" + axis), length));
  };
  const float fx = focal("x", "w", lens.width), fy = focal("y", "h", lens.height);
  if (fx == 0 && fy == 0) fields.Get("camera_angle_x");  // which is missing: says so
  lens.fx = fx == 0 ? fy : fx;
  lens.fy = fy == 0 ? lens.fx : fy;
  for (const char* key : {"fl_x", "fl_y"})
    if (fields.Has(key) && !(fields.Get(key).Number() > 0)) fields.Get(key).Fail("is not positive");
  lens.cx = float(fields.Has("cx") ? fields.Pixels("cx", "w") : lens.width / 2.0);
  lens.cy = float(fields.Has("cy") ? fields.Pixels("cy", "h") : lens.height / 2.0);
  return lens;
}

bool IsFisheye(const FrameFields& fields) {
  if (fields.Has("is_fisheye")) {
    const JsonField flag = fields.Get("is_fisheye");
    if (!flag.raw().is_boolean()) flag.Fail("expected true or false");
    if (flag.raw().get<bool>()) return true;
  }
  if (!fields.Has("camera_model")) return false;
  const JsonField model = fields.Get("camera_model");
  const std::string name = model.String();
  if (name == "OPENCV_FISHEYE") return true;
  if (name == "OPENCV" || name == "PINHOLE" || name == "SIMPLE_PINHOLE" ||
      name == "SIMPLE_RADIAL" || name == "RADIAL" || name == "PERSPECTIVE")
    return false;
  model.Fail("camera model " + name + " cannot be undistorted");
}

// nerfstudio's list of k1, k2, k3, k4, p1, p2 counts before single ones.
Distortion DistortionOf(const FrameFields& fields) {
  Distortion distortion;
  std::map<std::string, double> listed;
  if (fields.Has("distortion_params") &&
      !(fields.IsOwn("k1") && !fields.IsOwn("distortion_params"))) {
    const std::vector<float> list = fields.Get("distortion_params").Numbers(6);
    const char* const names[] = {"k1", "k2", "k3", "k4", "p1", "p2"};
    for (size_t i = 0; i < list.size(); ++i) listed[names[i]] = double(list[i]);
  }
  const auto k = [&](const char* key) {
    return listed.contains(key) ? listed[key] : fields.NumberOr(key, 0);
  };
  if (IsFisheye(fields)) {
    distortion.model = Distortion::Model::kFisheye;
    int i = 0;
    for (const char* key : {"k1", "k2", "k3", "k4"}) distortion.k[i++] = k(key);
    return distortion;
  }
  for (const char* key : {"k4", "k5", "k6"})
    if (k(key) != 0)
      fields.Get(listed.contains(key) ? "distortion_params" : key)
          .Fail(std::string(key) + ": terms beyond k3 cannot be undistorted");
  int i = 0;
  for (const char* key : {"k1", "k2", "p1", "p2", "k3"}) {
    distortion.k[i++] = k(key);
    if (k(key) != 0) distortion.model = Distortion::Model::kBrown;
  }
  return distortion;
}

// "./train/r_0" -> "train/r_0.png", since Blender's files omit the extension.
std::string ImageName(const std::string& named) {
  const std::string name = fs::path(ForwardSlashes(named)).lexically_normal().generic_string();
  return IsImageName(name) ? name : name + ".png";
}

// `transposed` counts matrices in the order of columns.
PoseProblem SetFramePose(const JsonField& field, size_t& transposed, SceneView& view) {
  const std::vector<double> values = field.NumbersOrNan();
  if (values.size() != 16 && values.size() != 12)
    field.Fail("found " + std::to_string(values.size()) + " numbers, expected a 4x4 matrix");
  std::array<double, 12> matrix;
  bool turned = false;
  const std::string problem = RowsOfPose(values, matrix, turned);
  if (!problem.empty()) return problem;
  transposed += turned;
  return SetPoseFromOpenGlWorldFromCam(matrix, view.camera, &view.center);
}

// The points that a file of cameras names, if it does.
void LoadPoints(const JsonField& file, SceneData& scene) {
  if (!file.Has("ply_file_path")) return;
  const std::string named = file["ply_file_path"].String();
  const std::string found = DataFiles(fs::path(file.file()).parent_path().string()).Find(named);
  const std::string path =
      found.empty() ? (fs::path(file.file()).parent_path() / named).string() : found;
  scene.coarse_points = !ReadPointsPly(path, scene.read_points, scene.point_colors);
}

// Adds the frames of one file to `views`, or to the scene's skipped ones.
void LoadFrames(const JsonField& file,
                const char* list,
                const SceneOptions& options,
                std::vector<SceneView>& views,
                SceneData& scene) {
  const fs::path folder = fs::path(file.file()).parent_path();
  const JsonField frames = file[list];
  DataFiles files(folder.string());
  size_t elsewhere = 0, transposed = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const JsonField frame = frames[i];
    const FrameFields fields(file, frame);
    const std::string named = frame["file_path"].String();
    SceneView view;
    view.name = ImageName(named);
    std::string problem = SetFramePose(frame["transform_matrix"], transposed, view);
    const FoundImage found = FindImage(files, named, options.resolution);
    view.image_path = found.path;
    elsewhere += found.elsewhere;
    const std::string mask = frame.Has("mask_path") ? frame["mask_path"].String() : "";
    if (!mask.empty()) view.mask_path = files.FindImage(mask);
    if (problem.empty() && found.path.empty())
      problem = "image " + (folder / found.tried).string() + " is missing";
    if (problem.empty() && !mask.empty() && view.mask_path.empty())
      problem = "mask " + (folder / mask).string() + " is missing";
    ImageInfo info;
    if (problem.empty()) {
      // Without w and h the intrinsics belong to the full-size image.
      const std::string full = files.FindImage(named);
      view.distortion = DistortionOf(fields);
      problem = Problem([&] { info = ReadImageInfo(full.empty() ? found.path : full); });
    }
    if (problem.empty()) {
      const Camera lens = LensOf(fields, info);  // missing fields fail the whole file
      problem = Problem([&] { FinishView(lens, found.divide_by, view); });
    }
    if (problem.empty())
      views.push_back(std::move(view));
    else
      scene.skipped.push_back({view.name, problem});
  }
  NoteElsewhere(elsewhere, options.resolution, scene);
  if (transposed > 0)
    scene.notes.push_back(file.file() + ": " + std::to_string(transposed) +
                          " matrices are in the order of columns and were transposed");
}

// nerfstudio's lists of names, each of which must be a view's. With a list for training, views in
// no list are left out where there are test views, as nerfstudio does.
void SplitByNames(const JsonField& file, SceneData& scene) {
  DataFiles files(fs::path(file.file()).parent_path().string());
  std::set<std::string> all;
  for (const SceneView& view : scene.train) all.insert(view.name);
  for (const SkippedFrame& frame : scene.skipped) all.insert(frame.name);
  const auto views_of = [&](const char* list) {
    std::set<std::string> names;
    for (size_t i = 0; file.Has(list) && i < file[list].size(); ++i) {
      const std::string name = file[list][i].String(), path = files.FindImage(name);
      const auto found =
          std::find_if(scene.train.begin(), scene.train.end(), [&](const SceneView& view) {
            return view.name == ImageName(name) || (!path.empty() && view.image_path == path);
          });
      if (found != scene.train.end())
        names.insert(found->name);
      else if (!all.contains(ImageName(name)))
        throw Error(file.file(), list, "has " + name + ", which is no frame's file_path");
    }
    return names;
  };
  const std::set<std::string> train = views_of("train_filenames");
  std::set<std::string> test = views_of("test_filenames");
  if (test.empty()) test = views_of("val_filenames");
  if (train.empty() && test.empty()) return;
  std::vector<SceneView> views = std::move(scene.train);
  scene.train.clear();
  size_t left = 0;
  for (SceneView& view : views) {
    const bool is_test = test.empty() ? !train.contains(view.name) : test.contains(view.name);
    if (is_test)
      scene.test.push_back(std::move(view));
    else if (train.empty() || train.contains(view.name))
      scene.train.push_back(std::move(view));
    else
      ++left;
  }
  if (left > 0) scene.notes.push_back(Format("{} views are in none of the file's lists", left));
  scene.own_split = true;
}

}  // namespace

bool IsBlenderScene(const std::string& path) {
  return fs::is_regular_file(path + "/transforms_train.json");
}

void LoadBlenderScene(const std::string& path, const SceneOptions& options, SceneData& scene) {
  scene.layout = "blender";
  const std::string path_of_json = path + "/transforms_train.json";
  const JsonField train(path_of_json, ReadJson(path_of_json));
  LoadFrames(train, "frames", options, scene.train, scene);
  LoadPoints(train, scene);
  for (const char* split : {"test", "val"}) {
    const std::string file = path + "/transforms_" + split + ".json";
    if (scene.own_split || !fs::exists(file)) continue;
    LoadFrames(JsonField(file, ReadJson(file)), "frames", options, scene.test, scene);
    scene.own_split = true;
    if (split != std::string("test") && options.eval)
      scene.notes.push_back(file + " has the test views, since there is no transforms_test.json");
  }
  scene.renderings = !scene.train.empty() && ReadImageInfo(scene.train[0].image_path).channels == 4;
}

bool IsNerfstudioScene(const std::string& path) {
  return fs::is_regular_file(path + "/transforms.json");
}

void LoadNerfstudioScene(const std::string& path, const SceneOptions& options, SceneData& scene) {
  scene.layout = "nerfstudio";
  const std::string path_of_json = path + "/transforms.json";
  const JsonField file(path_of_json, ReadJson(path_of_json));
  LoadFrames(file, "frames", options, scene.train, scene);
  LoadPoints(file, scene);
  if (file.Has("test_frames")) {  // ScanNet++
    LoadFrames(file, "test_frames", options, scene.test, scene);
    scene.own_split = true;
  } else {
    SplitByNames(file, scene);
  }
}

}  // namespace cosplat

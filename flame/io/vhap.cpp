// VHAP's export, the training data of GaussianAvatars (Qian et al. 2024).
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <tuple>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

bool AllZero(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return x == 0; });
}

}  // namespace

void ReadVhapSubject(const Npz& npz, TrackedVideo& video) {
  std::string problem = CopyFinite("shape", npz.Get("shape").values, video.shape);
  if (problem.empty() && npz.Has("static_offset")) {
    const NpyArray& array = npz.Get("static_offset");
    if (array.shape.size() > 1 && array.shape.back() != 3)
      throw Error(npz.path(), "static_offset", "is not of three numbers for each vertex, [V, 3]");
    const std::vector<double>& offsets = array.values;
    if (!AllZero(offsets)) problem = CopyFinite("static_offset", offsets, video.static_offset);
  }
  if (!problem.empty()) throw Error(npz.path(), problem);
}

namespace {

// Copies an axis-angle vector; returns what is wrong with it, if anything.
std::string CopyVector(const Npz& npz,
                       const std::string& name,
                       size_t offset,
                       size_t expected,
                       std::array<float, 3>& out) {
  const std::vector<double>& values = npz.Get(name).values;
  if (values.size() != expected)
    return Format("{} has {} numbers, expected {}", name, values.size(), expected);
  std::vector<float> numbers;
  const std::string problem = CopyFinite(name, values, numbers);
  if (problem.empty()) std::copy_n(numbers.begin() + offset, 3, out.begin());
  return problem;
}

std::string ReadParams(const std::string& path, FlameParams& params) {
  if (!fs::is_regular_file(path)) return "parameter file " + path + " is missing";
  const Npz npz = Npz::Read(path);
  struct {
    const char* name;
    size_t offset, expected;
    std::array<float, 3>* target;
  } const fields[] = {{"rotation", 0, 3, &params.pose[0]},
                      {"neck_pose", 0, 3, &params.pose[1]},
                      {"jaw_pose", 0, 3, &params.pose[2]},
                      {"eyes_pose", 0, 6, &params.pose[3]},
                      {"eyes_pose", 3, 6, &params.pose[4]},
                      {"translation", 0, 3, &params.translation}};
  for (const auto& field : fields) {
    const std::string problem =
        CopyVector(npz, field.name, field.offset, field.expected, *field.target);
    if (!problem.empty()) return problem;
  }
  if (npz.Has("dynamic_offset") && !AllZero(npz.Get("dynamic_offset").values))
    return "dynamic_offset is not zero: offsets per frame are not supported";
  return CopyFinite("expr", npz.Get("expr").values, params.expression);
}

std::string SetVhapPose(const JsonField& field, size_t& transposed, Camera& camera) {
  std::array<double, 12> matrix;
  const std::string problem = CopyTransform(field, transposed, matrix);
  return problem.empty() ? SetPoseFromOpenGlWorldFromCam(matrix, camera) : problem;
}

std::string FindFiles(const JsonField& field, Transforms& of, TrackedFrame& frame) {
  const fs::path folder = of.folder;
  const std::string image = field["file_path"].String();
  frame.image_path = of.files.FindImage(image);
  if (frame.image_path.empty()) return "image " + (folder / image).string() + " is missing";
  if (!field.Has("fg_mask_path")) return "";
  const std::string mask = field["fg_mask_path"].String();
  frame.mask_path = of.files.FindImage(mask);
  if (!frame.mask_path.empty() || of.request.images->Info(frame.image_path).channels == 4)
    return "";
  return "mask " + (folder / mask).string() + " is missing";
}

// Fills `frame`; returns why it is unusable, if it is.
std::string LoadFrame(const JsonField& field, Transforms& of, TrackedFrame& frame) {
  frame.timestep = field.Has("timestep_index") ? field["timestep_index"].Integer()
                                               : NumberIn(frame.name).value_or(frame.timestep);
  if (field.Has("camera_index")) frame.camera_index = field["camera_index"].Integer();
  std::string problem = SetVhapPose(field["transform_matrix"], of.transposed, frame.camera);
  if (!problem.empty()) return problem;
  const Camera lens = LensOfTransforms(of.file, field);
  const std::string named = field["flame_param_path"].String();
  const std::string found = of.files.Find(named);
  const std::string params = found.empty() ? (fs::path(of.folder) / named).string() : found;
  return Problem([&] {  // a damaged file only costs its frame
    problem = ReadParams(params, frame.params);
    if (problem.empty() && of.request.images) problem = FindFiles(field, of, frame);
    return problem.empty() ? FinishTrackedFrame(lens, of.request, frame) : problem;
  });
}

// Two images that one camera took at one time are of a file whose time steps are something else.
void CheckInstants(const std::string& file, const std::vector<TrackedFrame>& frames) {
  std::map<std::tuple<int, int, std::array<float, 3>>, const TrackedFrame*> taken;
  for (const TrackedFrame& frame : frames) {
    const auto [at, added] =
        taken.insert({{frame.timestep, frame.camera_index, frame.camera.Center()}, &frame});
    if (!added)
      throw Error(file,
                  "timestep_index",
                  Format("is {} for both {} and {}, of one camera: it counts the moments",
                         frame.timestep,
                         at->second->name,
                         frame.name));
  }
}

// The file with the subject's parameters: canonical, or that of the first frame in the list.
std::string SubjectFile(const std::string& path) {
  const std::string canonical = path + "/canonical_flame_param.npz";
  if (fs::exists(canonical)) return canonical;
  const std::string json_path = path + "/transforms_train.json";
  return path + "/" +
         JsonField(json_path, ReadJson(json_path))["frames"][0]["flame_param_path"].String();
}

}  // namespace

void LoadVhapTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video) {
  const auto load = [&](const std::string& file, std::vector<TrackedFrame>& frames) {
    LoadTransforms(file, fs::path(file).parent_path().string(), request, LoadFrame, frames, video);
    CheckInstants(file, frames);
  };
  load(path + "/transforms_train.json", video.train);
  const std::string test = FirstThatExists(path, {"transforms_test.json", "transforms_val.json"});
  if (!test.empty()) load(test, video.test);
  CheckSkipped(path, video.train.size() + video.test.size(), video.skipped);
  // From the canonical file or otherwise the first frame's.
  ReadVhapSubject(Npz::Read(SubjectFile(path)), video);
  if (request.options.test_frames < 0) return;
  video.train.insert(video.train.end(), video.test.begin(), video.test.end());
  video.test.clear();
  SortByTime(video.train);
  SplitLastFrames(request.options.test_frames, video);
}

}  // namespace cosplat

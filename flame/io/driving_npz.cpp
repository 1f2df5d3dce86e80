// Driving sequences as CAP4D (Taubner et al. 2025) publishes them: parameters and a camera only;
// and those that GaussianAvatars (Qian et al. 2024) keeps beside its point clouds.
#include <algorithm>
#include <cmath>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// The [4, 4] or [1, 4, 4] cam_from_world with OpenGL's camera axes; the identity if absent.
PoseProblem SetDrivingPose(const Npz& npz, Camera& camera) {
  std::array<double, 9> rotation{1, 0, 0, 0, -1, 0, 0, 0, -1};
  std::array<double, 3> translation{};
  if (!npz.Has("extr")) return SetPose(rotation, translation, camera);
  const NpyArray& extr = npz.Get("extr");
  if (extr.size() < 16) throw Error(npz.path(), "extr", "is not a 4x4 matrix");
  for (int r = 0; r < 3; ++r) {
    const double sign = r == 0 ? 1 : -1;
    for (int c = 0; c < 3; ++c) rotation[3 * r + c] = sign * extr.values[4 * r + c];
    translation[r] = sign * extr.values[4 * r + 3];
  }
  return SetPose(rotation, translation, camera);
}

// The sequence's first camera. Without intrinsics: a long focal length, such that a head at a metre
// and a half fills the image.
Camera DrivingCamera(const Npz& npz) {
  constexpr int kDefaultSide = 512;
  Camera lens;
  lens.width = lens.height = kDefaultSide;
  if (npz.Has("resolutions")) {
    const NpyArray& size = npz.Get("resolutions");
    const auto usable = [](double side) { return side >= 1 && side <= kMaxSide; };
    if (size.size() < 2 || !usable(size.values[0]) || !usable(size.values[1]))
      throw Error(npz.path(), "resolutions", "expected height and width");
    lens.height = int(size.values[0]);
    lens.width = int(size.values[1]);
  }
  lens.fx = float(ScalarOr(npz, "fx", 5.0 * lens.width));
  lens.fy = float(ScalarOr(npz, "fy", lens.fx));
  lens.cx = float(ScalarOr(npz, "cx", lens.width / 2.0));
  lens.cy = float(ScalarOr(npz, "cy", lens.height / 2.0));
  for (const float focal : {lens.fx, lens.fy})
    if (!(focal > 0) || !std::isfinite(focal))
      throw Error(npz.path(), "fx", "is not positive and finite");
  if (!std::isfinite(lens.cx) || !std::isfinite(lens.cy))
    throw Error(npz.path(), "cx", "is not finite");
  const PoseProblem problem = SetDrivingPose(npz, lens);
  if (!problem.empty()) throw Error(npz.path(), "extr", problem);
  return lens;
}

// The vectors of CAP4D, then of GaussianAvatars. CAP4D's eyes rotate alike.
struct DrivingVectors {
  const char* name;
  size_t width;  // 3 per target, or 3 for all of them
  std::vector<std::array<float, 3>*> targets;
};
std::vector<DrivingVectors> DrivingVectorsOf(FlameParams& params) {
  auto& pose = params.pose;
  return {{"tra", 3, {&params.translation}},
          {"rot", 3, {&pose[0]}},
          {"neck_rot", 3, {&pose[1]}},
          {"jaw_rot", 3, {&pose[2]}},
          {"eye_rot", 3, {&pose[3], &pose[4]}},
          {"translation", 3, {&params.translation}},
          {"rotation", 3, {&pose[0]}},
          {"neck_pose", 3, {&pose[1]}},
          {"jaw_pose", 3, {&pose[2]}},
          {"eyes_pose", 6, {&pose[3], &pose[4]}}};
}

// What makes a frame of GaussianAvatars unusable, if anything does.
std::string OffsetProblem(const Npz& npz, size_t row, size_t count) {
  if (!npz.Has("dynamic_offset")) return "";
  const NpyArray& offset = npz.Get("dynamic_offset", {long(count), -1, 3});
  const size_t width = offset.size() / count;
  const auto begin = offset.values.begin() + long(row * width);
  const bool zero = std::all_of(begin, begin + long(width), [](double x) { return x == 0; });
  return zero ? "" : "dynamic_offset is not zero: offsets per frame are not supported";
}

bool IsAtRest(const FlameParams& params) {
  const auto zero = [](const auto& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](float x) { return x == 0; });
  };
  return zero(params.expression) && zero(params.translation) &&
         std::all_of(params.pose.begin(), params.pose.end(), zero);
}

// Fills the parameters of frame `row`; returns why it is unusable, if it is.
std::string ReadRow(const Npz& npz, size_t row, size_t count, FlameParams& params) {
  std::string problem = CopyRow("expr", npz.Get("expr"), row, params.expression);
  for (const DrivingVectors& vector : DrivingVectorsOf(params)) {
    if (!problem.empty() || !npz.Has(vector.name)) continue;
    std::vector<float> numbers;
    const NpyArray& array = npz.Get(vector.name, {long(count), long(vector.width)});
    problem = CopyRow(vector.name, array, row, numbers);
    if (!problem.empty()) continue;
    for (size_t i = 0; i < vector.targets.size(); ++i)
      std::copy_n(numbers.begin() + long(3 * i % vector.width), 3, vector.targets[i]->begin());
  }
  return problem.empty() ? OffsetProblem(npz, row, count) : problem;
}

// Of both tools' names, rows k and k + 5 being one part of the pose; without any the part rests.
void NoteMissingVectors(const Npz& npz, TrackedVideo& video) {
  FlameParams ignored;
  const std::vector<DrivingVectors> vectors = DrivingVectorsOf(ignored);
  const size_t parts = vectors.size() / 2;
  const bool released = npz.Has("static_offset");
  for (size_t k = 0; k < parts; ++k)
    if (!npz.Has(vectors[k].name) && !npz.Has(vectors[k + parts].name))
      video.notes.push_back(Format("{}: has no {}, which stays at rest",
                                   npz.path(),
                                   vectors[released ? k + parts : k].name));
}

}  // namespace

void LoadDrivingNpz(const Npz& npz, TrackedVideo& video) {
  const Camera camera = DrivingCamera(npz);
  video.frames_per_second = FrameRateOf(npz);
  const NpyArray& expressions = npz.Get("expr", {-1, -1});
  const size_t count = expressions.shape[0];
  if (expressions.shape[1] == 0) throw Error(npz.path(), "expr", "has no coefficients");
  NoteMissingVectors(npz, video);
  const bool has_subject = npz.Has("static_offset");  // GaussianAvatars'
  if (has_subject) ReadVhapSubject(npz, video);
  for (size_t i = 0; i < count; ++i) {
    TrackedFrame frame;
    frame.name = std::to_string(i);
    frame.timestep = int(i);
    frame.has_image = false;
    frame.camera = camera;
    std::string problem = ReadRow(npz, i, count, frame.params);
    if (problem.empty() && has_subject && IsAtRest(frame.params)) problem = "has no parameters";
    KeepOrSkip(std::move(frame), problem, video.test, video);
  }
}

}  // namespace cosplat

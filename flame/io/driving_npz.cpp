// Driving sequences as CAP4D (Taubner et al. 2025) publishes them: parameters and a camera only.
#include <algorithm>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/npz.h"

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
    if (size.size() < 2 || !(size.values[0] >= 1) || !(size.values[1] >= 1))
      throw Error(npz.path(), "resolutions", "expected height and width");
    lens.height = int(size.values[0]);
    lens.width = int(size.values[1]);
  }
  lens.fx = float(ScalarOr(npz, "fx", 5.0 * lens.width));
  lens.fy = float(ScalarOr(npz, "fy", lens.fx));
  lens.cx = float(ScalarOr(npz, "cx", lens.width / 2.0));
  lens.cy = float(ScalarOr(npz, "cy", lens.height / 2.0));
  if (!(lens.fx > 0 && lens.fy > 0)) throw Error(npz.path(), "fx", "is not positive");
  const PoseProblem problem = SetDrivingPose(npz, lens);
  if (!problem.empty()) throw Error(npz.path(), "extr", problem);
  return lens;
}

// Fills the parameters of frame `row`; returns why it is unusable, if it is.
std::string ReadRow(const Npz& npz, size_t row, size_t count, FlameParams& params) {
  std::string problem = CopyRow("expr", npz.Get("expr"), row, params.expression);
  auto& pose = params.pose;
  struct {
    const char* name;
    std::vector<std::array<float, 3>*> targets;
  } const vectors[] = {{"tra", {&params.translation}},
                       {"rot", {&pose[0]}},
                       {"neck_rot", {&pose[1]}},
                       {"jaw_rot", {&pose[2]}},
                       {"eye_rot", {&pose[3], &pose[4]}}};  // both eyes rotate alike
  for (const auto& vector : vectors) {
    if (!problem.empty() || !npz.Has(vector.name)) continue;
    std::vector<float> numbers;
    problem = CopyRow(vector.name, npz.Get(vector.name, {long(count), 3}), row, numbers);
    if (!problem.empty()) continue;
    for (std::array<float, 3>* target : vector.targets)
      std::copy_n(numbers.begin(), 3, target->begin());
  }
  return problem;
}

}  // namespace

void LoadDrivingNpz(const Npz& npz, TrackedVideo& video) {
  const Camera camera = DrivingCamera(npz);
  video.frames_per_second = FrameRateOf(npz);
  const size_t count = npz.Get("expr", {-1, -1}).shape[0];
  for (size_t i = 0; i < count; ++i) {
    TrackedFrame frame;
    frame.name = std::to_string(i);
    frame.timestep = int(i);
    frame.has_image = false;
    frame.camera = camera;
    const std::string problem = ReadRow(npz, i, count, frame.params);
    KeepOrSkip(std::move(frame), problem, video.test, video);
  }
}

}  // namespace cosplat

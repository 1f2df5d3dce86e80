// metrical-tracker's output (Zielonka et al. 2022), which INSTA, FlashAvatar, GaussianBlendshapes
// and RGBAvatar start from: a file of torch.save per frame. The head's root stays where FLAME puts
// it; the camera moves.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "flame/io/pickle.h"
#include "flame/io/track_layouts.h"
#include "flame/math/rotation.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/median.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The test set of the published comparisons on INSTA's data.
constexpr int kMetricalTestFrames = 350;
// Shapes of one subject are equal up to float's rounding.
constexpr float kSameShape = 1e-4f;

// A checkpoint's arrays by their place, such as "flame.jaw".
class Checkpoint {
 public:
  explicit Checkpoint(const std::string& path) : path_(path), pickle_(ReadTorchFile(path)) {}

  bool Has(const std::string& group, const std::string& key) const {
    const PickleValue* values = pickle_.root().Find(group);
    return values != nullptr && (key.empty() || values->Find(key) != nullptr);
  }
  // The array's numbers; `key` empty: of the group itself. Throws Error if it is missing or has
  // another number of them than `count` (0: any).
  std::vector<double> Numbers(const std::string& group,
                              const std::string& key,
                              size_t count) const {
    const std::string name = key.empty() ? group : group + "." + key;
    if (!Has(group, key)) throw Error(path_, name, "is missing");
    const PickleValue* value = pickle_.root().Find(group);
    if (!key.empty()) value = value->Find(key);
    std::vector<double> numbers = ArrayOf(path_, name, *value).values;
    if (count > 0 && numbers.size() != count)
      throw Error(path_, name, Format("has {} numbers, expected {}", numbers.size(), count));
    return numbers;
  }

 private:
  std::string path_;
  Pickle pickle_;
};

// Six numbers -> axis-angle; returns what is wrong with them, if anything.
std::string SetJoint(const std::string& name, const double* six, std::array<float, 3>& joint) {
  std::array<double, 6> rows;
  std::copy_n(six, 6, rows.begin());
  math::Mat3<double> rotation;
  if (!flame_math::RotationFrom6d(rows, rotation)) return name + " is no rotation";
  const math::Vec3<double> vector = flame_math::AxisAngleOf(rotation);
  for (int i = 0; i < 3; ++i) joint[i] = float(vector[i]);
  return "";
}

std::string SetMetricalParams(const Checkpoint& file, FlameParams& params) {
  std::string problem = CopyFinite("flame.exp", file.Numbers("flame", "exp", 0), params.expression);
  if (problem.empty())
    problem = CopyFinite("flame.shape", file.Numbers("flame", "shape", 0), params.shape);
  const std::vector<double> jaw = file.Numbers("flame", "jaw", 6);
  const std::vector<double> eyes = file.Numbers("flame", "eyes", 12);
  if (problem.empty()) problem = SetJoint("flame.jaw", jaw.data(), params.pose[2]);
  if (problem.empty()) problem = SetJoint("flame.eyes", eyes.data(), params.pose[3]);
  if (problem.empty()) problem = SetJoint("flame.eyes", eyes.data() + 6, params.pose[4]);
  if (!problem.empty() || !file.Has("flame", "eyelids")) return problem;
  std::vector<float> eyelids;
  problem = CopyFinite("flame.eyelids", file.Numbers("flame", "eyelids", 2), eyelids);
  if (problem.empty()) std::copy_n(eyelids.begin(), 2, params.eyelids.begin());
  return problem;
}

// "opencv": cam_from_world and the matrix of intrinsics in pixels; img_size: height, width.
std::string SetMetricalCamera(const Checkpoint& file, Camera& camera) {
  const std::vector<double> size = file.Numbers("img_size", "", 2);
  const std::vector<double> k = file.Numbers("opencv", "K", 9);
  const std::vector<double> r = file.Numbers("opencv", "R", 9);
  const std::vector<double> t = file.Numbers("opencv", "t", 3);
  for (const double side : size)
    if (!(side >= 1 && side <= 1 << 20)) return "img_size has a side of " + std::to_string(side);
  camera.height = int(size[0]);
  camera.width = int(size[1]);
  camera.fx = float(k[0]);
  camera.fy = float(k[4]);
  camera.cx = float(k[2]);
  camera.cy = float(k[5]);
  const bool finite = std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
                      std::isfinite(camera.cx) && std::isfinite(camera.cy);
  if (!finite || !(camera.fx > 0 && camera.fy > 0))
    return "opencv.K has a focal length or centre that is not finite and positive";
  std::array<double, 9> rotation;
  std::array<double, 3> translation;
  std::copy_n(r.begin(), 9, rotation.begin());
  std::copy_n(t.begin(), 3, translation.begin());
  return SetPose(rotation, translation, camera);
}

// How a frame's shape differs from the subject's, if it does.
std::string OtherShape(const std::vector<float>& shape, const std::vector<float>& subject) {
  if (shape.size() != subject.size())
    return Format("flame.shape has {} numbers, in other frames {}", shape.size(), subject.size());
  for (size_t i = 0; i < shape.size(); ++i)
    if (std::abs(shape[i] - subject[i]) > kSameShape)
      return Format("flame.shape[{}] is {}, in other frames {}", i, shape[i], subject[i]);
  return "";
}

}  // namespace

std::string ReadMetricalFrame(const std::string& path, FlameParams& params, Camera& camera) {
  if (!fs::is_regular_file(path)) return "parameter file " + path + " is missing";
  const Checkpoint file(path);
  std::string problem = SetMetricalParams(file, params);
  if (problem.empty()) problem = SetMetricalCamera(file, camera);
  return problem.empty() ? "" : path + ": " + problem;
}

void SettleShape(TrackedVideo& video) {
  std::vector<size_t> sizes;
  for (auto* list : {&video.train, &video.test})
    for (const TrackedFrame& frame : *list) sizes.push_back(frame.params.shape.size());
  if (sizes.empty()) return;
  const size_t size = Median(sizes);
  std::vector<std::vector<float>> shapes;
  for (auto* list : {&video.train, &video.test})
    for (const TrackedFrame& frame : *list)
      if (frame.params.shape.size() == size) shapes.push_back(frame.params.shape);
  video.shape = MedianOf(video.source, "flame.shape", shapes);
  for (auto* list : {&video.train, &video.test}) {
    std::vector<TrackedFrame> kept;
    for (TrackedFrame& frame : *list) {
      const std::string problem = OtherShape(frame.params.shape, video.shape);
      frame.params.shape.clear();
      KeepOrSkip(std::move(frame), problem, kept, video);
    }
    list->swap(kept);
  }
}

void LoadMetricalTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video) {
  video.head_is_fixed = true;
  // The tracker's own folder of images is input/, without masks; INSTA's preprocessing makes
  // images/, with alpha. Its video.avi shows the fit, not the person.
  const TrackFiles files =
      FindTrackFiles(path, {"images", "image", "input"}, false, request.images, video);
  std::map<int, std::string> checkpoints;
  const std::string other = NumberedFiles(path + "/checkpoint", ".frame", checkpoints);
  if (!other.empty()) video.skipped.push_back({other, "its name is not the number of a frame"});
  for (const auto& [number, file] : checkpoints) {
    const std::string& checkpoint = file;  // clang 14's lambdas capture no structured bindings
    TrackedFrame frame;
    frame.name = fs::path(checkpoint).stem().string();
    frame.timestep = number;
    frame.has_image = request.images != nullptr;
    const std::string problem = Problem([&] {  // a damaged file only costs its frame
      Camera lens;
      const std::string wrong = ReadMetricalFrame(checkpoint, frame.params, lens);
      frame.camera = lens;
      return wrong.empty() ? FindAndFinish(lens, request, files, video, frame) : wrong;
    });
    KeepOrSkip(std::move(frame), problem, video.train, video);
  }
  SettleShape(video);
  CheckSkipped(path, video.train.size(), video.skipped);
  SplitLastFrames(TestFrameCount(request.options, video.train.size(), kMetricalTestFrames), video);
}

}  // namespace cosplat

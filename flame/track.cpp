#include "flame/track.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "flame/eyelids.h"
#include "flame/io/track_layouts.h"
#include "flame/math/rotation.h"
#include "flame/pose.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

}  // namespace

bool ProportionsDiffer(int width, int height, int other_width, int other_height) {
  return std::abs(double(other_width) * height / other_height - width) > 1;
}

Camera CameraAt(const Camera& lens, int width, int height, int resolution, const Camera& pose) {
  const auto divided = [&](int side) {
    return std::max(1, int(std::lround(double(side) / resolution)));
  };
  Camera camera = lens.Resized(width, height).Resized(divided(width), divided(height));
  camera.rotation = pose.rotation;
  camera.translation = pose.translation;
  return camera;
}

std::string FinishTrackedFrame(const Camera& lens,
                               const TrackRequest& request,
                               TrackedFrame& frame) {
  ImageInfo info{lens.width, lens.height, 0};
  if (!frame.image_path.empty()) {
    // Turned as viewers show it, unless only the image as it is stored fits its camera: a tag that
    // was left on pixels which had been turned.
    const ImageInfo stored = request.images->Info(frame.image_path);
    info = stored.Upright();
    frame.orientation = stored.orientation;
    if (ProportionsDiffer(info.width, info.height, lens.width, lens.height) &&
        !ProportionsDiffer(stored.width, stored.height, lens.width, lens.height)) {
      info = stored;
      frame.orientation = 1;
    }
  }
  if (ProportionsDiffer(info.width, info.height, lens.width, lens.height))
    return "image " + frame.image_path + " is " + SizeText(info.width, info.height) +
           ", its camera " + SizeText(lens.width, lens.height);
  if (!frame.mask_path.empty()) {
    const ImageInfo mask = request.images->Info(frame.mask_path).Upright();
    if (mask.width != info.width || mask.height != info.height)
      return "mask " + frame.mask_path + " is " + SizeText(mask.width, mask.height) +
             ", its image " + SizeText(info.width, info.height);
  }
  frame.camera = CameraAt(lens, info.width, info.height, request.options.resolution, frame.camera);
  return "";
}

std::string CopyFinite(const std::string& name,
                       const std::vector<double>& values,
                       std::vector<float>& out) {
  out.clear();
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(float(values[i]))) return name + "[" + std::to_string(i) + "] is not finite";
    out.push_back(float(values[i]));
  }
  return "";
}

// The last `count` time steps, with all cameras' frames.
void SplitLastFrames(int count, TrackedVideo& video) {
  std::set<int> instants;
  for (const TrackedFrame& frame : video.train) instants.insert(frame.timestep);
  if (count < 0 || size_t(count) >= instants.size())
    throw Error(video.source,
                "test frames",
                Format("{} of {} frames would leave none to train on", count, instants.size()));
  if (count == 0) return;
  const int first = *std::prev(instants.end(), count);
  const auto boundary =
      std::stable_partition(video.train.begin(), video.train.end(), [&](const TrackedFrame& f) {
        return f.timestep < first;
      });
  video.test.assign(std::make_move_iterator(boundary), std::make_move_iterator(video.train.end()));
  video.train.erase(boundary, video.train.end());
}

// Trackers that keep the head in place write a separate camera for every frame. If these cameras
// differ only in translation, the head actually moved in front of a static camera:
//   p_cam = R x + t_i = R (x + R^T (t_i - t_0)) + t_0.
// The images are unchanged, and whatever does not move with the head (a bust, the light) keeps its
// place in the world.
void HoldCameraStill(TrackedVideo& video) {
  if (video.head_is_fixed) return;  // until MoveHead
  std::vector<TrackedFrame*> frames;
  for (auto* list : {&video.train, &video.test})
    for (TrackedFrame& frame : *list) frames.push_back(&frame);
  if (frames.empty()) return;
  const Camera first = frames[0]->camera;
  for (const TrackedFrame* frame : frames)
    if (frame->camera.rotation != first.rotation || frame->camera_index != frames[0]->camera_index)
      return;
  for (TrackedFrame* frame : frames) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        frame->params.translation[i] +=
            first.rotation[3 * k + i] * (frame->camera.translation[k] - first.translation[k]);
    frame->camera.translation = first.translation;
  }
}

// R_i x + t_i = C (R x' + t') + c, where x' is x about the root's joint J: with R = C^T R_i,
// t' = C^T (t_i - c) - (J - R J). The last term is the root's transform, as the poser has it.
void MoveHead(const FlameModel& flame, TrackedVideo& video) {
  if (!video.head_is_fixed) return;
  std::vector<TrackedFrame*> frames;
  for (auto* list : {&video.train, &video.test})
    for (TrackedFrame& frame : *list) frames.push_back(&frame);
  if (frames.empty()) return;
  // The subject of a driving sequence may have more coefficients than the avatar's model.
  std::vector<float> shape = video.shape;
  shape.resize(std::min(shape.size(), size_t(flame.shape_count)));
  const FlamePoser<double> poser(flame, shape, video.static_offset);
  const std::array<float, 9> front = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  const std::array<float, 3> place = frames[0]->camera.translation;
  FlameRig<double> rig;
  for (TrackedFrame* frame : frames) {
    Camera& camera = frame->camera;
    math::Mat3<double> rotation;  // C^T R_i
    math::Vec3<double> offset{};  // C^T (t_i - c)
    for (int i = 0; i < 3; ++i) {
      const double sign = front[4 * i];
      offset[i] = sign * (double(camera.translation[i]) - place[i]);
      for (int k = 0; k < 3; ++k) rotation(i, k) = sign * camera.rotation[3 * i + k];
    }
    auto parameters = FlamePoser<double>::ParametersOf(frame->params);
    parameters.expression.resize(
        std::min(parameters.expression.size(), size_t(flame.expression_count)));
    const math::Vec3<double> root = flame_math::AxisAngleOf(rotation);
    parameters.pose[0] = {root.x, root.y, root.z};
    poser.Prepare(parameters, rig);
    for (int i = 0; i < 3; ++i) {
      frame->params.pose[0][i] = float(parameters.pose[0][i]);
      frame->params.translation[i] = float(offset[i] - rig.transforms.translation[0][i]);
    }
    camera.rotation = front;
    camera.translation = place;
  }
  video.head_is_fixed = false;
}

double DepthOfHead(const TrackedFrame& frame) {
  double depth = frame.camera.translation[2];
  for (size_t k = 0; k < 3; ++k)
    depth += frame.camera.rotation[6 + k] * frame.params.translation[k];
  return depth;
}

double FaceSizeIn(const TrackedFrame& frame) {
  constexpr double kMinDistance = 0.01;  // metres
  return kFaceSize * frame.camera.fx / std::max(DepthOfHead(frame), kMinDistance);
}

std::string UnusedExpressions(const FlameModel& flame,
                              const std::vector<const FlameParams*>& faces) {
  const size_t used = size_t(flame.expression_count);
  size_t given = 0;
  double all = 0, left = 0;
  for (const FlameParams* face : faces) {
    given = std::max(given, face->expression.size());
    for (size_t k = 0; k < face->expression.size(); ++k) {
      const double square = double(face->expression[k]) * face->expression[k];
      all += square;
      if (k >= used) left += square;
    }
  }
  if (left == 0) return "";
  return Format(
      "{} of {} expression coefficients are used, all that the model has; the others are {:.0f} % "
      "of "
      "the expressions (sum of squares)",
      std::min(used, given),
      given,
      100 * left / all);
}

bool TracksEyelids(const TrackedVideo& video) {
  const auto moved = [](const TrackedFrame& frame) {
    return frame.params.eyelids != std::array<float, 2>{};
  };
  return std::any_of(video.train.begin(), video.train.end(), moved) ||
         std::any_of(video.test.begin(), video.test.end(), moved);
}

void EyelidsToExpression(const FlameModel& model, TrackedVideo& video) {
  for (auto* list : {&video.train, &video.test})
    for (TrackedFrame& frame : *list) EyelidsToExpression(model, frame.params);
}

void EyelidsFromExpression(const FlameModel& model, TrackedVideo& video) {
  for (auto* list : {&video.train, &video.test})
    for (TrackedFrame& frame : *list) EyelidsFromExpression(model, frame.params);
}

namespace {

// "vhap" or "insta" by the first frame of the first list that has one, or "".
std::string LayoutOfTransforms(const std::string& path) {
  if (fs::exists(path + "/canonical_flame_param.npz") &&
      fs::exists(path + "/transforms_train.json"))
    return "vhap";
  for (const char* name : {"/transforms_train.json", "/transforms.json"}) {
    if (!fs::is_regular_file(path + name)) continue;
    const JsonField frames = JsonField(path + name, ReadJson(path + name))["frames"];
    if (frames.size() == 0) continue;
    if (frames[0].Has("flame_param_path")) return "vhap";
    if (frames[0].Has("exp_path") || frames[0].Has("mesh_path")) return "insta";
    return "";
  }
  return "";
}

bool HasCheckpoints(const std::string& path) {
  if (!fs::is_directory(path + "/checkpoint")) return false;
  for (const auto& entry : fs::directory_iterator(path + "/checkpoint"))
    if (entry.path().extension() == ".frame") return true;
  return false;
}

[[noreturn]] void ThrowNoTrack(const std::string& path) {
  if (fs::exists(path + "/transforms_train.json"))
    throw Error(path + "/transforms_train.json",
                "frames",
                "have neither flame_param_path (VHAP, GaussianAvatars) nor exp_path (INSTA)");
  throw Error(path,
              "contains no tracked video: expected flame_params.json (IMavatar), "
              "transforms_train.json (VHAP, INSTA), checkpoint/*.frame (metrical-tracker) or "
              "smirk.npz (SMIRK)");
}

}  // namespace

std::string TrackLayoutOf(const std::string& path) {
  if (path.ends_with(".npz")) return IsSmirkNpz(Npz::Read(path)) ? "smirk" : "npz";
  if (fs::is_regular_file(path + "/flame_params.json")) return "imavatar";
  const std::string layout = LayoutOfTransforms(path);
  if (!layout.empty()) return layout;
  if (HasCheckpoints(path)) return "metrical-tracker";
  return fs::is_regular_file(path + "/smirk.npz") ? "smirk" : "";
}

// Other programs do not say what they fit: it is FLAME.
void CheckIsOf(const FlameModel& flame, const TrackedVideo& video) {
  if (video.model_vertices == 0 && !flame.landmarks.empty())
    throw Error(video.source,
                "does not say of which model it is, so it is FLAME's, and means nothing to '" +
                    flame.name + "'");
  if (video.model_vertices != 0 && video.model_vertices != flame.own_vertex_count())
    throw Error(video.source,
                Format("is of a model of {} vertices, '{}' has {}",
                       video.model_vertices,
                       flame.name,
                       flame.own_vertex_count()));
  if (!video.model_sha256.empty() && !flame.sha256.empty() && video.model_sha256 != flame.sha256)
    throw Error(video.source,
                "is of another model (sha256 " + video.model_sha256 + ") than '" + flame.name +
                    "' (" + flame.sha256 + "); give that which it was tracked with");
}

TrackedVideo LoadTrack(const std::string& path, const TrackRequest& request) {
  const int resolution = request.options.resolution;
  if (resolution < 1) throw Error("resolution", std::to_string(resolution) + " is not positive");
  if (!fs::exists(path)) throw Error(path, "does not exist");
  TrackedVideo video;
  video.source = path;
  const bool is_file = path.ends_with(".npz");
  if (is_file && request.images) throw Error(path, "has parameters but no images to train on");
  video.layout = TrackLayoutOf(path);
  if (video.layout == "npz") {
    LoadDrivingNpz(Npz::Read(path), video);
  } else if (video.layout == "smirk") {
    LoadSmirkTrack(path, Npz::Read(is_file ? path : path + "/smirk.npz"), request, video);
  } else if (video.layout == "imavatar") {
    LoadImavatarTrack(path, request, video);
  } else if (video.layout == "vhap") {
    LoadVhapTrack(path, request, video);
  } else if (video.layout == "insta") {
    LoadInstaTrack(path, request, video);
  } else if (video.layout == "metrical-tracker") {
    LoadMetricalTrack(path, request, video);
  } else {
    ThrowNoTrack(path);
  }
  if (request.images) SkipImpossible(video);  // a driver may exaggerate
  CheckSkipped(path, video.train.size() + video.test.size(), video.skipped);
  if (video.train.empty() && !is_file) throw Error(path, "contains no frames to train on");
  ConvertToMetres(request.options.flame, video);
  if (request.options.flame) {
    CheckIsOf(*request.options.flame, video);
    EyelidsToExpression(*request.options.flame, video);
    MoveHead(*request.options.flame, video);
  }
  HoldCameraStill(video);
  return video;
}

TrackedVideo LoadDrivingSequence(const std::string& path, const FlameModel* flame) {
  TrackRequest request;
  request.options.flame = flame;
  return LoadTrack(path, request);
}

std::vector<const TrackedFrame*> InstantsOf(const TrackedVideo& video) {
  std::map<int, const TrackedFrame*> instants;
  for (const auto* list : {&video.train, &video.test})
    for (const TrackedFrame& frame : *list) {
      const TrackedFrame*& kept = instants[frame.timestep];
      if (!kept || frame.camera_index < kept->camera_index) kept = &frame;
    }
  std::vector<const TrackedFrame*> frames;
  for (const auto& [timestep, frame] : instants) frames.push_back(frame);
  return frames;
}

std::vector<TrackedFrame*> FramesInOrder(TrackedVideo& video) {
  std::vector<TrackedFrame*> frames;
  for (auto* list : {&video.train, &video.test})
    for (TrackedFrame& frame : *list) frames.push_back(&frame);
  std::stable_sort(frames.begin(), frames.end(), [](const auto* a, const auto* b) {
    return a->timestep < b->timestep;
  });
  return frames;
}

}  // namespace cosplat

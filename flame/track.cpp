#include "flame/track.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "flame/io/track_layouts.h"
#include "splat/base/error.h"

namespace cosplat {

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
  if (!frame.image_path.empty()) info = request.images->Info(frame.image_path);
  if (ProportionsDiffer(info.width, info.height, lens.width, lens.height))
    return "image " + frame.image_path + " is " + SizeText(info.width, info.height) +
           ", its camera " + SizeText(lens.width, lens.height);
  if (!frame.mask_path.empty()) {
    const ImageInfo mask = request.images->Info(frame.mask_path);
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
                std::to_string(count) + " of " + std::to_string(instants.size()) +
                    " frames would leave none to train on");
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

TrackedVideo LoadTrack(const std::string& path, const TrackRequest& request) {
  const int resolution = request.options.resolution;
  if (resolution < 1) throw Error("resolution", std::to_string(resolution) + " is not positive");
  if (!std::filesystem::exists(path)) throw Error(path, "does not exist");
  TrackedVideo video;
  video.source = path;
  if (IsDrivingNpz(path)) {
    if (request.images) throw Error(path, "has parameters but no images to train on");
    LoadDrivingNpz(path, video);
  } else if (IsImavatarTrack(path)) {
    LoadImavatarTrack(path, request, video);
  } else if (IsVhapTrack(path)) {
    LoadVhapTrack(path, request, video);
  } else {
    throw Error(path,
                "contains no tracked video: expected flame_params.json (IMavatar) or "
                "transforms_train.json (VHAP)");
  }
  CheckSkipped(path, video.train.size() + video.test.size(), video.skipped);
  if (video.train.empty() && video.layout != "npz")
    throw Error(path, "contains no frames to train on");
  HoldCameraStill(video);
  return video;
}

TrackedVideo LoadDrivingSequence(const std::string& path) { return LoadTrack(path, {}); }

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

}  // namespace cosplat

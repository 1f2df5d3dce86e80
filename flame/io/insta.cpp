// INSTA's preprocessed data (Zielonka et al. 2023): cameras, images with alpha and a split. Its own
// files hold each frame's expression and a mesh, but neither jaw, eyes nor shape: these come from
// the tracker's checkpoints, which published copies of the data have beside it.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// INSTA's own test set; its script leaves nothing to train on if there are no more frames.
constexpr int kInstaTestFrames = 350;

std::string SetInstaPose(const JsonField& field, size_t& transposed, Camera& camera) {
  std::array<double, 12> matrix;
  const std::string problem = CopyTransform(field, transposed, matrix);
  return problem.empty() ? SetPoseFromWorldFromCam(matrix, camera) : problem;
}

// Whether a path from a file stays in its folder.
bool StaysInside(const fs::path& path) {
  return path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

// INSTA copies the checkpoint's pose: another one shows that the two are of different frames.
bool SamePose(const Camera& a, const Camera& b) {
  constexpr float kRounding = 1e-3f;
  bool same = true;
  for (size_t i = 0; i < 9; ++i) same &= std::abs(a.rotation[i] - b.rotation[i]) < kRounding;
  for (size_t i = 0; i < 3; ++i) same &= std::abs(a.translation[i] - b.translation[i]) < kRounding;
  return same;
}

// Fills `frame`; returns why it is unusable, if it is.
std::string LoadInstaFrame(const JsonField& field, Transforms& of, TrackedFrame& frame) {
  const std::string& path = of.folder;
  const TrackRequest& request = of.request;
  frame.timestep = NumberIn(frame.name).value_or(frame.timestep);
  const std::string image = field["file_path"].String();
  const Camera lens = LensOfTransforms(of.file, field);
  std::string problem = SetInstaPose(field["transform_matrix"], of.transposed, frame.camera);
  if (!problem.empty()) return problem;
  const fs::path relative(ForwardSlashes(image));
  if (relative.is_relative() && !StaysInside(relative))
    return "file_path " + image + " leads out of the folder";
  return Problem([&] {
    Camera tracked;  // its intrinsics are those of the tracker's images
    const std::string checkpoint = path + "/checkpoint/" + frame.name + ".frame";
    problem = ReadMetricalFrame(checkpoint, frame.params, tracked);
    if (problem.empty() && !SamePose(frame.camera, tracked))
      problem = "transform_matrix is not the camera of " + checkpoint;
    if (request.images) frame.image_path = of.files.FindImage(image);
    if (problem.empty() && request.images && frame.image_path.empty())
      problem = "image " + path + "/" + image + " is missing";
    return problem.empty() ? FinishTrackedFrame(lens, request, frame) : problem;
  });
}

}  // namespace

void LoadInstaTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video) {
  video.head_is_fixed = true;
  if (!fs::is_directory(path + "/checkpoint"))
    throw Error(path,
                "checkpoint/",
                "is missing: INSTA's files have no jaw, eyes and shape, which are in "
                "metrical-tracker's folder checkpoint/ (copy it here)");
  const auto load = [&](const std::string& file, std::vector<TrackedFrame>& frames) {
    LoadTransforms(file, path, request, LoadInstaFrame, frames, video);
  };
  const std::string train = path + "/transforms_train.json";
  const std::string test = FirstThatExists(path, {"transforms_test.json", "transforms_val.json"});
  if (fs::exists(train)) {
    load(train, video.train);
    if (!test.empty()) load(test, video.test);
  } else {
    load(path + "/transforms.json", video.train);
  }
  SettleShape(video);
  CheckSkipped(path, video.train.size() + video.test.size(), video.skipped);
  const bool own_split =
      request.options.test_frames < 0 && !video.train.empty() && !video.test.empty();
  if (!own_split) {
    std::move(video.test.begin(), video.test.end(), std::back_inserter(video.train));
    video.test.clear();
  }
  // The files are written as their frames are done: not in order.
  SortByTime(video.train);
  SortByTime(video.test);
  if (!own_split)
    SplitLastFrames(TestFrameCount(request.options, video.train.size(), kInstaTestFrames), video);
}

}  // namespace cosplat

// IMavatar's layout (Zheng et al. 2022), also used by PointAvatar's and SplattingAvatar's data.
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The layout's mesh is FLAME's scaled by four; the camera's translation is divided to get metres.
constexpr double kMeshScale = 4;
// Image size to which the old form of `intrinsics` refers, px.
constexpr double kOldFormSide = 512;
// Image size assumed for a driving sequence without images.
constexpr int kDefaultSide = 512;

// [-fx/W, fy/H, cx/W, cy/H] (signs vary), or the old form in pixels of a 512x512 image.
Camera LensOf(const JsonField& field, int width, int height) {
  const std::vector<float> k = field.Numbers(4);
  const bool old_form = k[3] > 1;
  const double sx = old_form ? width / kOldFormSide : width;
  const double sy = old_form ? height / kOldFormSide : height;
  Camera lens;
  lens.width = width;
  lens.height = height;
  lens.fx = float(std::abs(k[0]) * sx);
  lens.fy = float(std::abs(k[1]) * sy);
  lens.cx = float(k[2] * sx);
  lens.cy = float(k[3] * sy);
  if (!(lens.fx > 0 && lens.fy > 0)) field.Fail("has a focal length of zero");
  return lens;
}

// world_mat: cam_from_world for the enlarged mesh with OpenGL's camera axes.
PoseProblem SetImavatarPose(const JsonField& field, size_t& transposed, Camera& camera) {
  std::array<double, 12> m;
  const std::string problem = CopyTransform(field, transposed, m);
  if (!problem.empty()) return problem;
  std::array<double, 9> rotation;
  std::array<double, 3> translation;
  for (int r = 0; r < 3; ++r) {
    const double sign = r == 0 ? 1 : -1;
    for (int c = 0; c < 3; ++c) rotation[3 * r + c] = sign * m[4 * r + c];
    translation[r] = sign * m[4 * r + 3] / kMeshScale;
  }
  return SetPose(rotation, translation, camera);
}

// An addition to the layout: our own tracker's (flame/io/imavatar_writer.h).
std::string SetEyelids(const JsonField& field, FlameParams& params) {
  const std::vector<double> lids = field.NumbersOrNan();
  if (lids.size() != params.eyelids.size())
    return "eyelids has " + std::to_string(lids.size()) + " numbers, expected 2";
  std::vector<float> finite;
  const std::string problem = CopyFinite("eyelids", lids, finite);
  if (problem.empty()) params.eyelids = {finite[0], finite[1]};
  return problem;
}

std::string SetParams(const JsonField& frame, size_t expression_count, FlameParams& params) {
  const std::vector<double> expression = frame["expression"].NumbersOrNan();
  if (expression.size() != expression_count)
    return Format("expression has {} numbers, expected {}", expression.size(), expression_count);
  const std::vector<double> pose = frame["pose"].NumbersOrNan();
  if (pose.size() != 3 * kFlameJoints)
    return "pose has " + std::to_string(pose.size()) + " numbers, expected 15";
  std::vector<float> joints;
  std::string problem = CopyFinite("expression", expression, params.expression);
  if (problem.empty()) problem = CopyFinite("pose", pose, joints);
  if (!problem.empty()) return problem;
  for (int j = 0; j < kFlameJoints; ++j)
    for (int k = 0; k < 3; ++k) params.pose[j][k] = joints[3 * j + k];
  return frame.Has("eyelids") ? SetEyelids(frame["eyelids"], params) : "";
}

// Size of the first existing image: intrinsics are fractions of it.
ImageInfo ImageSize(const TrackFiles& files, const JsonField& frames) {
  if (files.video.reader) return files.video.size;
  for (size_t i = 0; !files.image_folder.empty() && i < frames.size(); ++i) {
    const std::string path =
        files.in_image_folder->FindImage(StemOf(frames[i]["file_path"].String()));
    ImageInfo info;
    if (!path.empty() && Problem([&] { info = files.images->Info(path).Upright(); }).empty())
      return info;
  }
  return {kDefaultSide, kDefaultSide, 0};
}

// Frames are in order of time. Where their names are numbers, those say it: "1, 10, 11, 2" is the
// order of text.
void SortByNumber(const std::string& file, TrackedVideo& video) {
  std::map<int, size_t> places;
  for (size_t i = 0; i < video.train.size(); ++i) {
    const std::optional<int> number = NumberIn(video.train[i].name);
    if (!number || !places.emplace(*number, i).second) return;
  }
  std::vector<TrackedFrame> sorted;
  bool moved = false;
  for (const auto& [number, place] : places) {
    moved |= place != sorted.size();
    sorted.push_back(video.train[place]);
  }
  if (!moved) return;
  for (size_t i = 0; i < sorted.size(); ++i) sorted[i].timestep = video.train[i].timestep;
  video.train = std::move(sorted);
  video.notes.push_back(file +
                        ": its frames are not in the order of their numbers, and were sorted");
}

int ImavatarTestFrames(const JsonField& file, const TrackOptions& options, size_t usable) {
  if (options.test_frames < 0 && file.Has("test_frames")) return file["test_frames"].Integer();
  return TestFrameCount(options, usable);
}

}  // namespace

void LoadImavatarTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video) {
  const std::string json_path = path + "/flame_params.json";
  const JsonField file(json_path, ReadJson(json_path));
  const JsonField frames = file["frames"];
  video.shape = file["shape_params"].Numbers();
  // An addition to the layout: our own tracker's (flame/io/imavatar_writer.h).
  if (file.Has("vertices")) video.model_vertices = file["vertices"].Integer(1, 1 << 24);
  if (file.Has("model_sha256")) video.model_sha256 = file["model_sha256"].String();
  if (file.Has("static_offset")) video.static_offset = file["static_offset"].Numbers();
  const TrackFiles files = FindTrackFiles(path, {"images", "image"}, true, request.images, video);
  const ImageInfo size = ImageSize(files, frames);
  const Camera lens = LensOf(file["intrinsics"], size.width, size.height);
  const size_t expression_count = frames.size() > 0 ? frames[0]["expression"].size() : 0;
  size_t transposed = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const JsonField field = frames[i];
    TrackedFrame frame;
    frame.name = StemOf(field["file_path"].String());
    frame.timestep = int(i);
    frame.has_image = request.images != nullptr;
    std::string problem = SetImavatarPose(field["world_mat"], transposed, frame.camera);
    if (problem.empty()) problem = SetParams(field, expression_count, frame.params);
    if (problem.empty())
      problem = Problem([&] { return FindAndFinish(lens, request, files, video, frame); });
    KeepOrSkip(std::move(frame), problem, video.train, video);
  }
  NoteTransposed(json_path, transposed, video);
  CheckSkipped(path, video.train.size(), video.skipped);
  SortByNumber(json_path, video);
  SplitLastFrames(ImavatarTestFrames(file, request.options, video.train.size()), video);
}

}  // namespace cosplat

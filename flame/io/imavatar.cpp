// IMavatar's layout (Zheng et al. 2022), also used by PointAvatar's and SplattingAvatar's data.
#include <charconv>
#include <cmath>
#include <filesystem>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The layout's mesh is FLAME's scaled by four; the camera's translation is divided to get metres.
constexpr double kMeshScale = 4;
// Image size to which the old form of `intrinsics` refers, px.
constexpr double kOldFormSide = 512;
// Image size assumed for a driving sequence without images.
constexpr int kDefaultSide = 512;
constexpr double kDefaultTestPart = 0.2;

// The sources of the images.
struct Sources {
  const ImageFiles* images = nullptr;
  std::string image_folder;  // or empty: a video, or nothing
  std::string mask_folder;   // or empty
  ImageFiles::Video video;   // or none
};

std::string FirstThatExists(const std::string& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (fs::exists(folder + "/" + name)) return folder + "/" + name;
  return "";
}

Sources FindSources(const std::string& path, const ImageFiles* images, TrackedVideo& video) {
  Sources sources;
  sources.images = images;
  if (!images) return sources;
  sources.image_folder = FirstThatExists(path, {"images", "image"});
  sources.mask_folder = FirstThatExists(path, {"mask", "masks"});
  if (!sources.image_folder.empty()) return sources;
  video.video_path = FirstThatExists(path, {"video.mp4", "video.avi", "video.mkv"});
  if (video.video_path.empty())
    throw Error(path, "has no folder image or images and no video.mp4, .avi or .mkv");
  sources.video = images->OpenVideo(video.video_path);
  video.video = sources.video.reader;
  return sources;
}

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
  if (!(lens.fx > 0 && lens.fy > 0))
    throw Error(field.file(), field.path(), "has a focal length of zero");
  return lens;
}

// world_mat: cam_from_world for the enlarged mesh with OpenGL's camera axes.
PoseProblem SetImavatarPose(const JsonField& field, Camera& camera) {
  const std::vector<double> m = field.NumbersOrNan();
  if (m.size() != 12 && m.size() != 16)
    return "world_mat has " + std::to_string(m.size()) + " numbers, expected 12";
  std::array<double, 9> rotation;
  std::array<double, 3> translation;
  for (int r = 0; r < 3; ++r) {
    const double sign = r == 0 ? 1 : -1;
    for (int c = 0; c < 3; ++c) rotation[3 * r + c] = sign * m[4 * r + c];
    translation[r] = sign * m[4 * r + 3] / kMeshScale;
  }
  return SetPose(rotation, translation, camera);
}

std::string SetParams(const JsonField& frame, size_t expression_count, FlameParams& params) {
  const std::vector<double> expression = frame["expression"].NumbersOrNan();
  if (expression.size() != expression_count)
    return "expression has " + std::to_string(expression.size()) + " numbers, expected " +
           std::to_string(expression_count);
  const std::vector<double> pose = frame["pose"].NumbersOrNan();
  if (pose.size() != 3 * kFlameJoints)
    return "pose has " + std::to_string(pose.size()) + " numbers, expected 15";
  std::vector<float> joints;
  std::string problem = CopyFinite("expression", expression, params.expression);
  if (problem.empty()) problem = CopyFinite("pose", pose, joints);
  if (!problem.empty()) return problem;
  for (int j = 0; j < kFlameJoints; ++j)
    for (int k = 0; k < 3; ++k) params.pose[j][k] = joints[3 * j + k];
  return "";
}

// Video frames are counted from 0, the layout's names from 1.
std::string FindVideoFrame(const Sources& sources, const TrackedVideo& video, TrackedFrame& frame) {
  int number = 0;
  const char* end = frame.name.data() + frame.name.size();
  const auto [last, code] = std::from_chars(frame.name.data(), end, number);
  if (code != std::errc() || last != end) return "its name is not the number of a video frame";
  frame.video_frame = number - 1;
  if (number >= 1 && number <= sources.video.frame_count) return "";
  return video.video_path + " has " + std::to_string(sources.video.frame_count) + " frames";
}

// Sets the paths of image and mask; returns what is missing.
std::string FindFiles(const Sources& sources, const TrackedVideo& video, TrackedFrame& frame) {
  if (video.video) {
    const std::string problem = FindVideoFrame(sources, video, frame);
    if (!problem.empty()) return problem;
  } else {
    const std::vector<std::string> names{frame.name + ".png", frame.name + ".jpg"};
    frame.image_path = FirstThatExists(sources.image_folder, names);
    if (frame.image_path.empty())
      return "image " + sources.image_folder + "/" + frame.name + ".png is missing";
    if (sources.images->Info(frame.image_path).channels == 4) return "";
  }
  if (sources.mask_folder.empty()) return "";
  frame.mask_path =
      FirstThatExists(sources.mask_folder, {frame.name + ".png", frame.name + ".jpg"});
  if (frame.mask_path.empty())
    return "mask " + sources.mask_folder + "/" + frame.name + ".png is missing";
  return "";
}

// Size of the first existing image: intrinsics are fractions of it.
ImageInfo ImageSize(const Sources& sources, const JsonField& frames) {
  if (sources.video.reader) return sources.video.size;
  for (size_t i = 0; !sources.image_folder.empty() && i < frames.size(); ++i) {
    const std::string name = fs::path(frames[i]["file_path"].String()).stem().string();
    const std::string path = FirstThatExists(sources.image_folder, {name + ".png", name + ".jpg"});
    ImageInfo info;
    if (!path.empty() && Problem([&] { info = sources.images->Info(path); }).empty()) return info;
  }
  return {kDefaultSide, kDefaultSide, 0};
}

int TestFrameCount(const JsonField& file, const TrackOptions& options, size_t usable) {
  if (options.test_frames >= 0) return options.test_frames;
  if (file.Has("test_frames")) return file["test_frames"].Integer();
  return int(std::lround(kDefaultTestPart * double(usable)));
}

}  // namespace

bool IsImavatarTrack(const std::string& path) {
  return fs::is_regular_file(path + "/flame_params.json");
}

void LoadImavatarTrack(const std::string& path, const TrackRequest& request, TrackedVideo& video) {
  video.layout = "imavatar";
  const std::string json_path = path + "/flame_params.json";
  const Json json = ReadJson(json_path);
  const JsonField file(json_path, json);
  const JsonField frames = file["frames"];
  video.shape = file["shape_params"].Numbers();
  const Sources sources = FindSources(path, request.images, video);
  const ImageInfo size = ImageSize(sources, frames);
  const Camera lens = LensOf(file["intrinsics"], size.width, size.height);
  const size_t expression_count = frames.size() > 0 ? frames[0]["expression"].size() : 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const JsonField field = frames[i];
    TrackedFrame frame;
    frame.name = fs::path(field["file_path"].String()).stem().string();
    frame.timestep = int(i);
    frame.has_image = request.images != nullptr;
    std::string problem = SetImavatarPose(field["world_mat"], frame.camera);
    if (problem.empty()) problem = SetParams(field, expression_count, frame.params);
    if (problem.empty()) {
      const std::string broken = Problem([&] {
        if (request.images) problem = FindFiles(sources, video, frame);
        if (problem.empty()) problem = FinishTrackedFrame(lens, request, frame);
      });
      if (problem.empty()) problem = broken;
    }
    if (problem.empty()) {
      video.train.push_back(std::move(frame));
    } else {
      video.skipped.push_back({frame.name, problem});
    }
  }
  CheckSkipped(path, video.train.size(), video.skipped);
  SplitLastFrames(TestFrameCount(file, request.options, video.train.size()), video);
}

}  // namespace cosplat

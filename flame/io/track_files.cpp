// What layouts share: where images and masks are, numbers from JSON and .npz, the default split.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "flame/io/track_layouts.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/median.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultTestPart = 0.2;

// "images, image or input"
std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

// Video frames are counted from 0, their names from 1.
std::string FindVideoFrame(const TrackFiles& files,
                           const TrackedVideo& video,
                           TrackedFrame& frame) {
  const std::optional<int> number = NumberIn(frame.name);
  if (!number) return "its name is not the number of a video frame";
  frame.video_frame = *number - 1;
  if (*number >= 1 && *number <= files.video.frame_count) return "";
  return video.video_path + " has " + std::to_string(files.video.frame_count) + " frames";
}

}  // namespace

std::optional<int> NumberIn(const std::string& name) {
  const std::optional<int> number = NumberOf<int>(name);
  return number && *number >= 0 ? number : std::nullopt;
}

std::string FirstThatExists(const std::string& folder, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (fs::exists(folder + "/" + name)) return folder + "/" + name;
  return "";
}

std::string NumberedFiles(const std::string& folder,
                          const std::string& ending,
                          std::map<int, std::string>& files) {
  std::string other;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (ending.empty() ? !IsImageName(file.string()) : file.extension() != ending) continue;
    const std::optional<int> number = NumberIn(file.stem().string());
    if (number && files.emplace(*number, file.string()).second) continue;
    if (other.empty() || file.string() < other) other = file.string();
  }
  return other;
}

TrackFiles FindTrackFiles(const std::string& path,
                          const std::vector<std::string>& image_folders,
                          bool or_video,
                          const ImageFiles* images,
                          TrackedVideo& video) {
  TrackFiles files;
  files.images = images;
  if (!images) return files;
  files.image_folder = FirstThatExists(path, image_folders);
  files.mask_folder = FirstThatExists(path, {"mask", "masks"});
  files.in_image_folder = std::make_shared<DataFiles>(files.image_folder);
  files.in_mask_folder = std::make_shared<DataFiles>(files.mask_folder);
  if (!files.image_folder.empty()) return files;
  if (or_video) video.video_path = FirstThatExists(path, {"video.mp4", "video.avi", "video.mkv"});
  if (video.video_path.empty())
    throw Error(path,
                "has no folder " + Listed(image_folders) +
                    (or_video ? " and no video.mp4, .avi or .mkv" : ""));
  files.video = images->OpenVideo(video.video_path);
  video.video = files.video.reader;
  video.notes = files.video.notes;
  return files;
}

namespace {

std::string FindFrameFiles(const TrackFiles& files,
                           const TrackedVideo& video,
                           TrackedFrame& frame) {
  if (video.video) {
    const std::string problem = FindVideoFrame(files, video, frame);
    if (!problem.empty()) return problem;
  } else {
    frame.image_path = files.in_image_folder->FindImage(frame.name);
    if (frame.image_path.empty())
      return "image " + files.image_folder + "/" + frame.name + ".png is missing";
    if (files.mask_folder.empty() && files.images->Info(frame.image_path).channels == 4) return "";
  }
  if (files.mask_folder.empty()) return "";
  frame.mask_path = files.in_mask_folder->FindImage(frame.name);
  if (frame.mask_path.empty())
    return "mask " + files.mask_folder + "/" + frame.name + ".png is missing";
  return "";
}

}  // namespace

std::string FindAndFinish(const Camera& lens,
                          const TrackRequest& request,
                          const TrackFiles& files,
                          const TrackedVideo& video,
                          TrackedFrame& frame) {
  const std::string missing = request.images ? FindFrameFiles(files, video, frame) : "";
  return missing.empty() ? FinishTrackedFrame(lens, request, frame) : missing;
}

int TestFrameCount(const TrackOptions& options, size_t usable, int at_most) {
  if (options.test_frames >= 0) return options.test_frames;
  return std::min(int(std::lround(kDefaultTestPart * double(usable))), at_most);
}

Camera LensOfTransforms(const JsonField& file, const JsonField& frame) {
  const auto number = [&](const char* key) {
    return frame.Has(key) ? frame[key].Number() : file[key].Number();
  };
  Camera lens;
  const double width = number("w"), height = number("h");
  if (!(width >= 1 && width <= kMaxSide && height >= 1 && height <= kMaxSide))
    frame.Fail("has an image size that is not positive or above 2^20 px");
  lens.width = int(width);
  lens.height = int(height);
  for (const char* key : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "distortion_params"}) {
    const JsonField& of = frame.Has(key) ? frame : file;
    if (!of.Has(key)) continue;
    const JsonField field = of[key];
    for (const double k :
         field.raw().is_array() ? field.NumbersOrNan() : std::vector<double>{field.Number()})
      if (k != 0) field.Fail("is not zero: undistort a track's images first");
  }
  if (frame.Has("camera_angle_x") && !frame.Has("fl_x")) {  // a frame's own, in another form
    lens.fx = lens.fy = float(width / 2 / std::tan(frame["camera_angle_x"].Number() / 2));
  } else {
    lens.fx = float(number("fl_x"));
    lens.fy = float(number("fl_y"));
  }
  lens.cx = float(number("cx"));
  lens.cy = float(number("cy"));
  for (const float focal : {lens.fx, lens.fy})
    if (!(focal > 0) || !std::isfinite(focal))
      frame.Fail("has a focal length that is not positive and finite");
  if (!std::isfinite(lens.cx) || !std::isfinite(lens.cy))
    frame.Fail("has a principal point that is not finite");
  return lens;
}

std::string CopyRow(const std::string& name,
                    const NpyArray& array,
                    size_t row,
                    std::vector<float>& out) {
  const size_t width = array.size() / array.shape[0];
  const auto begin = array.values.begin() + long(row * width);
  return CopyFinite(name, std::vector<double>(begin, begin + long(width)), out);
}

std::vector<float> MedianOf(const std::string& file,
                            const std::string& name,
                            const std::vector<std::vector<float>>& rows) {
  std::vector<float> medians;
  for (size_t k = 0; !rows.empty() && k < rows[0].size(); ++k) {
    std::vector<float> column;
    for (const std::vector<float>& row : rows)
      if (std::isfinite(row[k])) column.push_back(row[k]);
    if (column.empty()) throw Error(file, name, "has no finite coefficient " + std::to_string(k));
    medians.push_back(Median(column));
  }
  return medians;
}

double ScalarOr(const Npz& npz, const char* name, double fallback) {
  if (!npz.Has(name)) return fallback;
  const NpyArray& array = npz.Get(name);
  if (array.size() == 0) throw Error(npz.path(), name, "is empty");
  return array.values[0];
}

double FrameRateOf(const Npz& npz) {
  const double rate = ScalarOr(npz, "fps", 0);
  if (!std::isfinite(rate) || rate < 0) throw Error(npz.path(), "fps", "is negative or not finite");
  return rate;
}

void KeepOrSkip(TrackedFrame frame,
                const std::string& problem,
                std::vector<TrackedFrame>& kept,
                TrackedVideo& video) {
  if (problem.empty()) {
    kept.push_back(std::move(frame));
  } else {
    video.skipped.push_back({frame.name, problem});
  }
}

std::string CopyTransform(const JsonField& field,
                          size_t& transposed,
                          std::array<double, 12>& matrix) {
  bool turned = false;
  const std::string problem = RowsOfPose(field.NumbersOrNan(), matrix, turned);
  transposed += turned;
  return problem;
}

void NoteTransposed(const std::string& file, size_t transposed, TrackedVideo& video) {
  if (transposed > 0)
    video.notes.push_back(file + ": " + std::to_string(transposed) +
                          " matrices are in the order of columns and were transposed");
}

void LoadTransforms(const std::string& file,
                    const std::string& folder,
                    const TrackRequest& request,
                    std::string (*load)(const JsonField&, Transforms&, TrackedFrame&),
                    std::vector<TrackedFrame>& frames,
                    TrackedVideo& video) {
  const JsonField json(file, ReadJson(file));
  const JsonField list = json["frames"];
  Transforms of{folder, json, request, DataFiles(folder)};
  for (size_t i = 0; i < list.size(); ++i) {
    const JsonField field = list[i];
    TrackedFrame frame;
    frame.name = StemOf(field["file_path"].String());
    frame.timestep = int(i);
    frame.has_image = request.images != nullptr;
    const std::string problem = load(field, of, frame);
    KeepOrSkip(std::move(frame), problem, frames, video);
  }
  NoteTransposed(file, of.transposed, video);
}

namespace {

float Norm(const std::array<float, 3>& v) { return std::hypot(v[0], v[1], v[2]); }

double DistanceOfHead(const TrackedFrame& frame) {
  std::array<float, 3> place = frame.camera.translation;
  for (size_t r = 0; r < 3; ++r)
    for (size_t k = 0; k < 3; ++k)
      place[r] += frame.camera.rotation[3 * r + k] * frame.params.translation[k];
  return Norm(place);
}

std::string ImpossibleAngle(const FlameParams& params) {
  constexpr std::array<float, 5> kMaxAngle{12.6f, 3.2f, 3.2f, 3.2f, 3.2f};  // radians
  constexpr std::array<const char*, 5> kJoints{"head", "neck", "jaw", "left eye", "right eye"};
  for (size_t j = 0; j < kJoints.size(); ++j)
    if (Norm(params.pose[j]) > kMaxAngle[j])
      return Format("turns the {} by {:.3g} radians", kJoints[j], Norm(params.pose[j]));
  return "";
}

std::string ImpossibleExpression(const FlameParams& params) {
  constexpr float kMax = 50;  // standard deviations
  for (const float e : params.expression)
    if (std::abs(e) > kMax) return Format("has an expression of {:g} standard deviations", e);
  return "";
}

}  // namespace

void SkipImpossible(TrackedVideo& video) {
  constexpr double kFar = 20;  // times the usual distance
  std::vector<double> distances;
  std::vector<size_t> counts;
  for (const auto* frames : {&video.train, &video.test})
    for (const TrackedFrame& frame : *frames) {
      distances.push_back(DistanceOfHead(frame));
      counts.push_back(frame.params.expression.size());
    }
  const double usual = Median(distances);
  const size_t expressions = Median(counts);
  size_t in_degrees = 0;
  std::string first;
  for (auto* frames : {&video.train, &video.test}) {
    std::vector<std::string> problems;
    for (const TrackedFrame& frame : *frames) {
      const double distance = DistanceOfHead(frame);
      std::string problem = ImpossibleAngle(frame.params);
      if (!problem.empty() && in_degrees++ == 0) first = frame.name + " " + problem;
      if (problem.empty()) problem = ImpossibleExpression(frame.params);
      if (problem.empty() && frame.params.expression.size() != expressions)
        problem = Format("has {} expression coefficients, other frames {}",
                         frame.params.expression.size(),
                         expressions);
      if (problem.empty() && usual > 0 && distance > kFar * usual)
        problem = Format("has the head at a distance of {:.3g}, others at {:.3g}", distance, usual);
      problems.push_back(problem);
    }
    const auto name_of = [](const TrackedFrame& frame) { return frame.name; };
    *frames = KeepUsable(std::move(*frames), problems, name_of, video.skipped);
  }
  // Some are small, and would pass for radians.
  if (in_degrees > 2 && 20 * in_degrees > counts.size())
    throw Error(video.source, first, "are the angles in degrees?");
}

void SortByTime(std::vector<TrackedFrame>& frames) {
  std::stable_sort(frames.begin(), frames.end(), [](const TrackedFrame& a, const TrackedFrame& b) {
    return a.timestep < b.timestep;
  });
}

}  // namespace cosplat

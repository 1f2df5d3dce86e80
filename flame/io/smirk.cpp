// What SMIRK's encoder (Retsinas et al. 2024) returns, one .npz per video. SMIRK itself writes no
// file of parameters; docs/conventions.md, "SMIRK", defines this one: its own names, a row per
// frame.
//
// The encoder sees a square crop and fits an orthographic camera to it:
//   u = c + c s (x + tx),  v = c - c s (y + ty),  c half the crop's side, cam = (s, tx, ty),
// and the crop is placed in the image by `tform`, which maps indices of pixels. Together this is
// u = u0 + k (x + tx) px. A camera at a distance of kDistance with the focal length k kDistance
// shows the same; the head is moved by what remains of u0 when the image's middle is the centre.
// The focal length follows s from frame to frame, not the distance: a far head would have to move
// by metres where the person moved by millimetres.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "flame/io/track_layouts.h"
#include "splat/base/camera.h"
#include "splat/base/error.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// Metres. A point 0.1 m before or behind the origin is seen 0.1 % further from the image's middle,
// or nearer: 0.2 px at 200 px.
constexpr double kDistance = 100;
constexpr double kDefaultCropSide = 224;
// Rounding of a crop's rotation or shear, relative to its scale.
constexpr double kCropTolerance = 1e-4;
constexpr float kMaxTranslation = 1000;  // metres

// The rows of a video: which arrays there are, and the size of the image.
struct SmirkRows {
  const Npz& npz;
  size_t count = 0;
  ImageInfo image;
  double crop_side = kDefaultCropSide;
};

// Row `row` of array `name`, [T, ...] with `width` numbers in a row.
std::string SmirkRow(const SmirkRows& rows,
                     const std::string& name,
                     size_t row,
                     size_t width,
                     std::vector<float>& out) {
  const std::string problem = CopyRow(name, rows.npz.Get(name), row, out);
  if (problem.empty() && width > 0 && out.size() != width)
    throw Error(
        rows.npz.path(), name, Format("has {} numbers a frame, expected {}", out.size(), width));
  return problem.empty() ? "" : name + " of row " + std::to_string(row) + ": " + problem;
}

std::string SetSmirkParams(const SmirkRows& rows, size_t row, FlameParams& params) {
  std::string problem = SmirkRow(rows, "expression_params", row, 0, params.expression);
  const auto copy = [&](const char* name, size_t width, float* target) {
    if (!problem.empty()) return;
    std::vector<float> numbers;
    problem = SmirkRow(rows, name, row, width, numbers);
    if (problem.empty()) std::copy(numbers.begin(), numbers.end(), target);
  };
  copy("pose_params", 3, params.pose[0].data());
  copy("jaw_params", 3, params.pose[2].data());
  if (rows.npz.Has("eyelid_params")) copy("eyelid_params", 2, params.eyelids.data());
  return problem;
}

// One axis of the map from the crop to the image: image = scale * crop + offset, px from the
// corners of the two.
struct CropAxis {
  double scale = 1, offset = 0;
};

// tform maps indices of the image's pixels to indices of the crop's, as skimage does: centres are
// at whole numbers. Without it, the whole image was resized to the crop.
std::string CropOf(const SmirkRows& rows, size_t row, CropAxis& x, CropAxis& y) {
  if (!rows.npz.Has("tform")) {
    x.scale = rows.image.width / rows.crop_side;
    y.scale = rows.image.height / rows.crop_side;
    return "";
  }
  std::vector<float> checked;
  const std::string problem = SmirkRow(rows, "tform", row, 9, checked);
  if (!problem.empty()) return problem;
  const double* m = &rows.npz.Get("tform").values[9 * row];
  const double slack = kCropTolerance * std::abs(m[0]);
  if (!(m[0] > 0 && m[4] > 0) || std::abs(m[1]) > slack || std::abs(m[3]) > slack || m[6] != 0 ||
      m[7] != 0 || std::abs(m[8] - 1) > kCropTolerance)
    return Format("tform of row {} is no scale and shift: [{}, {}, ...]", row, m[0], m[1]);
  x = {1 / m[0], 0.5 - (0.5 + m[2]) / m[0]};
  y = {1 / m[4], 0.5 - (0.5 + m[5]) / m[4]};
  return "";
}

std::string SetSmirkCamera(const SmirkRows& rows, size_t row, FlameParams& params, Camera& lens) {
  std::vector<float> cam;
  CropAxis x, y;
  std::string problem = SmirkRow(rows, "cam", row, 3, cam);
  if (problem.empty()) problem = CropOf(rows, row, x, y);
  if (!problem.empty()) return problem;
  if (!(cam[0] > 0))
    return Format("cam of row {} has a scale of {}, expected a positive one", row, cam[0]);
  const double half = rows.crop_side / 2;
  lens.width = rows.image.width;
  lens.height = rows.image.height;
  lens.cx = float(lens.width / 2.0);
  lens.cy = float(lens.height / 2.0);
  const double kx = half * cam[0] * x.scale, ky = half * cam[0] * y.scale;  // px per metre
  lens.fx = float(kDistance * kx);
  lens.fy = float(kDistance * ky);
  params.translation = {float(cam[1] + (x.scale * half + x.offset - lens.width / 2.0) / kx),
                        float(cam[2] - (y.scale * half + y.offset - lens.height / 2.0) / ky),
                        0};
  for (const float shift : params.translation)
    if (!(std::abs(shift) < kMaxTranslation) || !std::isfinite(lens.fx) || !std::isfinite(lens.fy))
      return "cam and tform of row " + std::to_string(row) + " are too large or too small";
  return SetPose({1, 0, 0, 0, -1, 0, 0, 0, -1}, {0, 0, kDistance}, lens);
}

// Which frame of the video, or which image in order of numbers, a row belongs to; counted from 0.
std::optional<int> FrameOfRow(const SmirkRows& rows, size_t row) {
  if (!rows.npz.Has("frame_numbers")) return int(row);
  const double number = rows.npz.Get("frame_numbers").values[row];
  if (!(number >= 0 && number < 1e9) || number != std::floor(number)) return std::nullopt;
  return int(number);
}

// The images in order of their numbers.
std::vector<std::string> ImagesInOrder(const TrackFiles& files) {
  std::map<int, std::string> numbered;
  const std::string other = NumberedFiles(files.image_folder, "", numbered);
  if (!other.empty())
    throw Error(other, "an image's name must be a number, which no other image has");
  std::vector<std::string> images;
  for (const auto& [number, image] : numbered) images.push_back(image);
  return images;
}

// Names of the images, or of a video's frames; sets the size of the first that can be read.
std::vector<std::string> FrameNames(const TrackFiles& files, SmirkRows& rows) {
  std::vector<std::string> names;
  if (files.video.reader) {
    rows.image = files.video.size;
    for (int i = 1; i <= files.video.frame_count; ++i) names.push_back(std::to_string(i));
  } else {
    for (const std::string& image : ImagesInOrder(files)) {
      names.push_back(fs::path(image).stem().string());
      if (rows.image.width == 0)  // an image that cannot be read costs its frame
        static_cast<void>(Problem([&] { rows.image = files.images->Info(image).Upright(); }));
    }
  }
  if (names.size() != rows.count && !rows.npz.Has("frame_numbers"))
    throw Error(rows.npz.path(),
                "frame_numbers",
                Format("is missing: there are {} rows and {} images", rows.count, names.size()));
  return names;
}

// Without images: as given, or the crop's.
ImageInfo GivenSize(const SmirkRows& rows) {
  const int side = int(rows.crop_side);
  if (!rows.npz.Has("image_size")) return {side, side, 0};
  const std::vector<double>& size = rows.npz.Get("image_size").values;
  const auto good = [](double length) { return length >= 1 && length <= kMaxSide; };
  if (size.size() != 2 || !good(size[0]) || !good(size[1]))
    throw Error(rows.npz.path(), "image_size", "expected height and width");
  return {int(size[1]), int(size[0]), 0};
}

// The subject's: SMIRK guesses one for every frame, of which the median is the least disturbed.
std::vector<float> SmirkShape(const Npz& npz) {
  const NpyArray& array = npz.Get("shape_params");
  const size_t count = array.shape.size() < 2 ? 1 : array.shape[0];
  std::vector<std::vector<float>> rows(count);
  for (size_t i = 0; i < count; ++i)
    for (size_t k = 0; k < array.size() / count; ++k)
      rows[i].push_back(float(array.values[i * (array.size() / count) + k]));
  return MedianOf(npz.path(), "shape_params", rows);
}

// Throws Error unless every array has a row per frame.
void CheckRows(const SmirkRows& rows) {
  for (const char* name : {"expression_params", "pose_params", "jaw_params", "cam"})
    rows.npz.Get(name);
  for (const char* name : {"expression_params",
                           "pose_params",
                           "jaw_params",
                           "cam",
                           "eyelid_params",
                           "tform",
                           "frame_numbers"}) {
    if (!rows.npz.Has(name)) continue;
    const std::vector<size_t>& shape = rows.npz.Get(name).shape;
    if (shape.empty() || shape[0] != rows.count)
      throw Error(rows.npz.path(),
                  name,
                  Format("has {} rows, expected {}", shape.empty() ? 0 : shape[0], rows.count));
  }
}

}  // namespace

bool IsSmirkNpz(const Npz& npz) { return npz.Has("expression_params"); }

void LoadSmirkTrack(const std::string& path,
                    const Npz& npz,
                    const TrackRequest& request,
                    TrackedVideo& video) {
  const NpyArray& expression = npz.Get("expression_params");
  SmirkRows rows{npz, expression.shape.empty() ? 0 : expression.shape[0], {}, kDefaultCropSide};
  CheckRows(rows);
  rows.crop_side = ScalarOr(npz, "crop_size", kDefaultCropSide);
  if (!(rows.crop_side >= 1 && rows.crop_side <= kMaxSide))
    throw Error(npz.path(), "crop_size", "is " + std::to_string(rows.crop_side) + " px");
  video.frames_per_second = FrameRateOf(npz);
  video.shape = SmirkShape(npz);
  const TrackFiles files = FindTrackFiles(path, {"images", "image"}, true, request.images, video);
  std::vector<std::string> names;
  if (request.images) names = FrameNames(files, rows);
  if (rows.image.width == 0) rows.image = GivenSize(rows);
  for (size_t i = 0; i < rows.count; ++i) {
    TrackedFrame frame;
    const std::optional<int> number = FrameOfRow(rows, i);
    frame.name = std::to_string(number.value_or(int(i)));
    frame.timestep = number.value_or(int(i));
    frame.has_image = request.images != nullptr;
    Camera lens;
    std::string problem = number ? SetSmirkParams(rows, i, frame.params)
                                 : "frame_numbers of row " + std::to_string(i) + " is no number";
    if (problem.empty()) problem = SetSmirkCamera(rows, i, frame.params, lens);
    frame.camera = lens;
    if (problem.empty() && request.images && size_t(*number) >= names.size())
      problem = "there are only " + std::to_string(names.size()) + " images";
    if (problem.empty() && request.images) frame.name = names[size_t(*number)];
    if (problem.empty())
      problem = Problem([&] { return FindAndFinish(lens, request, files, video, frame); });
    KeepOrSkip(std::move(frame), problem, video.train, video);
  }
  CheckSkipped(path, video.train.size(), video.skipped);
  if (fs::is_directory(path)) {
    SplitLastFrames(TestFrameCount(request.options, video.train.size()), video);
  } else {
    video.train.swap(video.test);  // a driving sequence
  }
}

}  // namespace cosplat

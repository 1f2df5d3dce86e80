#include "flame/io/landmarks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/image.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLandmarkFormat = "cosplat-landmarks";
constexpr int kLandmarkVersion = 1;
constexpr int kMaxImageSide = 65535;
// A face may reach beyond the image, but points further out than this many times its size are not
// pixels.
constexpr double kMaxOutside = 4;

struct NamedSet {
  LandmarkSet set;
  const char* name;
  int count;
};
constexpr NamedSet kLandmarkSets[] = {{LandmarkSet::kMediapipe478, "mediapipe-478", 478},
                                      {LandmarkSet::kMediapipe468, "mediapipe-468", 468},
                                      {LandmarkSet::kIbug68, "ibug-68", 68},
                                      {LandmarkSet::kOther, "other", 0}};

const NamedSet& Named(LandmarkSet set) {
  return *std::find_if(std::begin(kLandmarkSets), std::end(kLandmarkSets), [&](const NamedSet& s) {
    return s.set == set;
  });
}

LandmarkSet SetOf(const JsonField& field) {
  const std::string name = field.String();
  for (const NamedSet& known : kLandmarkSets)
    if (name == known.name) return known.set;
  field.Fail("is '" + name + "', expected mediapipe-478, mediapipe-468, ibug-68 or other");
}

std::array<double, 2> PointOf(const JsonField& field, const LandmarkVideo& video) {
  if (field.size() != 2 && field.size() != 3)
    field.Fail("has " + std::to_string(field.size()) + " numbers, expected x and y");
  const std::array<double, 2> point{field[0].Number(), field[1].Number()};
  const int sides[] = {video.width, video.height};
  for (int k = 0; k < 2; ++k)
    if (std::abs(point[k]) > kMaxOutside * sides[k])
      field.Fail(Format("is at {} px of an image of {} px", point[k], sides[k]));
  return point;
}

float FractionOf(const JsonField& field) {
  const double x = field.Number();
  if (x < 0 || x > 1) field.Fail("is " + std::to_string(x) + ", expected 0 to 1");
  return float(x);
}

DetectedFace FaceOf(const JsonField& field, const LandmarkVideo& video) {
  const JsonField points = field["points"];
  const size_t expected = size_t(video.point_count() > 0 ? video.point_count() : points.size());
  if (points.size() != expected || expected == 0)
    points.Fail("has " + std::to_string(points.size()) + " points, expected " +
                std::to_string(expected) + " of " + NameOf(video.set));
  DetectedFace face;
  for (size_t i = 0; i < expected; ++i) face.points.push_back(PointOf(points[i], video));
  if (field.Has("score")) face.score = FractionOf(field["score"]);
  if (!field.Has("blendshapes")) return face;
  const JsonField scores = field["blendshapes"];
  if (!scores.raw().is_object()) scores.Fail("is no object of names and scores");
  for (const auto& [name, value] : scores.raw().items())
    face.blendshapes[name] = FractionOf(scores[name]);
  return face;
}

LandmarkFrame FrameOf(const JsonField& field, const LandmarkVideo& video) {
  LandmarkFrame frame;
  frame.name = field["name"].String();
  frame.frame = field["frame"].Integer();
  const int earliest = video.frames.empty() ? 0 : video.frames.back().frame + 1;
  if (frame.frame < earliest)
    field["frame"].Fail("is " + std::to_string(frame.frame) + ", expected at least " +
                        std::to_string(earliest) + ": frames stand in order");
  const JsonField faces = field["faces"];
  for (size_t i = 0; i < faces.size(); ++i) frame.faces.push_back(FaceOf(faces[i], video));
  if (field.Has("matte"))
    frame.matte = (fs::path(field.file()).parent_path() / field["matte"].String()).string();
  return frame;
}

FrameCrop CropOf(const JsonField& field, int width, int height) {
  FrameCrop crop;
  crop.frame_width = field["frame_width"].Integer(1, kMaxImageSide);
  crop.frame_height = field["frame_height"].Integer(1, kMaxImageSide);
  // `side` is how squares were written when there was nothing else.
  const char* across = field.Has("side") ? "side" : "width";
  const char* down = field.Has("side") ? "side" : "height";
  Crop& part = crop.part;
  part.width = field[across].Integer(1, crop.frame_width);
  part.height = field[down].Integer(1, crop.frame_height);
  part.x = field["x"].Integer(0, crop.frame_width - part.width);
  part.y = field["y"].Integer(0, crop.frame_height - part.height);
  crop.width = width, crop.height = height;
  // Not stretched: one scale gives both sides, to less than a pixel.
  const double stretched = double(width) * part.height - double(height) * part.width;
  if (width > part.width || height > part.height ||
      std::abs(stretched) >= double(part.width) + part.height)
    field[across].Fail(Format("is {}, of {}, which images of {} cannot be",
                              part.width,
                              SizeText(part.width, part.height),
                              SizeText(width, height)));
  return crop;
}

Json CropJson(const FrameCrop& crop) {
  return {{"x", crop.part.x},
          {"y", crop.part.y},
          {"width", crop.part.width},
          {"height", crop.part.height},
          {"frame_width", crop.frame_width},
          {"frame_height", crop.frame_height}};
}

double FrameRateIn(const JsonField& file) {
  const double rate = file.NumberOr("frames_per_second", 0);
  if (rate < 0) throw Error(file.file(), "frames_per_second", Format("is {}, below 0", rate));
  return rate;
}

uint32_t ChecksumIn(const JsonField& field) {
  const double sum = field.Number();
  if (sum < 0 || sum > UINT32_MAX || sum != std::floor(sum))
    field.Fail(Format("is {:.0f}, expected a CRC-32", sum));
  return uint32_t(sum);
}

Json FaceJson(const DetectedFace& face) {
  Json json{{"points", face.points}, {"score", face.score}};
  if (!face.blendshapes.empty()) json["blendshapes"] = face.blendshapes;
  return json;
}

Json FrameJson(const LandmarkFrame& frame, const fs::path& folder) {
  Json json{{"name", frame.name}, {"frame", frame.frame}, {"faces", Json::array()}};
  for (const DetectedFace& face : frame.faces) json["faces"].push_back(FaceJson(face));
  if (!frame.matte.empty()) json["matte"] = fs::proximate(frame.matte, folder).string();
  return json;
}

}  // namespace

Camera FrameCrop::WholeCamera(const Camera& of_part) const {
  Camera whole = of_part;
  whole.width = frame_width, whole.height = frame_height;
  whole.fx = float(of_part.fx / scale_x()), whole.fy = float(of_part.fy / scale_y());
  const auto [cx, cy] = InFrame({of_part.cx, of_part.cy});
  whole.cx = float(cx), whole.cy = float(cy);
  return whole;
}

const char* NameOf(LandmarkSet set) { return Named(set).name; }

int LandmarkVideo::point_count() const {
  if (const int count = Named(set).count; count > 0) return count;
  for (const LandmarkFrame& frame : frames)
    if (!frame.faces.empty()) return int(frame.faces[0].points.size());
  return 0;
}

LandmarkVideo ReadLandmarks(const std::string& path) {
  const JsonField file(path, ReadJson(path));
  const std::string format = file["format"].String();
  if (format != kLandmarkFormat)
    throw Error(path, "format", "is '" + format + "', expected '" + kLandmarkFormat + "'");
  if (const int version = file["version"].Integer(); version != kLandmarkVersion)
    throw Error(path, "version", "is " + std::to_string(version) + ", expected 1");
  LandmarkVideo video;
  video.file = path;
  video.source = file["source"].String();
  if (file.Has("source_checksum")) video.source_checksum = ChecksumIn(file["source_checksum"]);
  video.width = file["width"].Integer(1, kMaxImageSide);
  video.height = file["height"].Integer(1, kMaxImageSide);
  if (file.Has("crop")) video.crop = CropOf(file["crop"], video.width, video.height);
  video.frames_per_second = FrameRateIn(file);
  video.set = SetOf(file["landmarks"]);
  const JsonField frames = file["frames"];
  for (size_t i = 0; i < frames.size(); ++i) video.frames.push_back(FrameOf(frames[i], video));
  if (file.Has("held_out")) video.held_out = file["held_out"].Integer(0, int(frames.size()));
  if (file.Has("left_out")) video.left_out = file["left_out"].Integer();
  return video;
}

void WriteLandmarks(const std::string& path, const LandmarkVideo& video) {
  const fs::path folder = fs::absolute(path).parent_path();
  Json json{{"format", kLandmarkFormat},
            {"version", kLandmarkVersion},
            {"source", video.source},
            {"width", video.width},
            {"height", video.height},
            {"frames_per_second", video.frames_per_second},
            {"landmarks", NameOf(video.set)},
            {"frames", Json::array()}};
  if (video.source_checksum) json["source_checksum"] = *video.source_checksum;
  if (video.crop) json["crop"] = CropJson(*video.crop);
  if (video.held_out > 0) json["held_out"] = video.held_out;
  if (video.left_out > 0) json["left_out"] = video.left_out;
  for (const LandmarkFrame& frame : video.frames)
    json["frames"].push_back(FrameJson(frame, folder));
  WriteFileAtomically(path, json.dump() + "\n");
}

}  // namespace cosplat

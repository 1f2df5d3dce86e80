#include "avatar/io/gaussian_avatars.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "avatar/io/avatar_file.h"
#include "avatar/model/avatar_mesh.h"
#include "flame/track.h"
#include "flame/vhap_teeth.h"
#include "splat/base/error.h"
#include "splat/io/ply.h"
#include "splat/io/ply_reader.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBinding = "binding_0";

// As the file has it: the value without needless digits.
std::string NumberText(double value) {
  const std::string text = std::to_string(value);
  return value == std::floor(value) ? text.substr(0, text.find('.')) : text;
}

// expected: how the faces are described in errors.
Buffer<int32_t> ReadFaces(const std::string& path, size_t face_count, const std::string& expected) {
  PlyReader reader(path);
  reader.Enter("vertex");
  const int column = reader.Require(kBinding);
  Buffer<int32_t> faces;
  for (size_t i = 0; i < reader.count(); ++i) {
    const double face = reader.Next()[size_t(column)];
    if (!(face >= 0 && face < double(face_count) && face == std::floor(face)))
      reader.Fail(kBinding, "is " + NumberText(face) + ", expected " + expected);
    faces.push_back(int32_t(face));
  }
  return faces;
}

std::string SubjectOf(const std::string& path, const std::string& otherwise) {
  const std::string beside = (fs::path(path).parent_path() / "flame_param.npz").string();
  if (fs::exists(beside)) return beside;
  if (otherwise.empty())
    throw Error(path,
                "flame_param.npz",
                "is not beside it: give the data set trained on, for the subject's shape");
  return otherwise;
}

// The subject's offsets for all vertices, or none. A track without teeth has none for these.
std::vector<float> OffsetFor(const FlameModel& flame, const TrackedVideo& track) {
  std::vector<float> offset = track.static_offset;
  if (offset.size() == 3 * size_t(flame.own_vertex_count()))
    offset.resize(3 * size_t(flame.vertex_count));
  if (!offset.empty() && offset.size() != 3 * size_t(flame.vertex_count))
    throw Error(track.source,
                "static_offset",
                "has " + std::to_string(offset.size()) + " numbers, the mesh has " +
                    std::to_string(flame.vertex_count) + " vertices");
  return offset;
}

void SetSubject(const TrackedVideo& track, const FlameModel& flame, AvatarModel& model) {
  if (track.shape.empty()) throw Error(track.source, "shape", "is missing");
  model.shape = track.shape;
  model.static_offset = OffsetFor(flame, track);
  std::vector<FlameParams> frames;
  for (const TrackedFrame* frame : InstantsOf(track)) frames.push_back(frame->params);
  if (frames.empty()) throw Error(track.source, "expr", "has no frames");
  model.trained_range = RangeOf(frames);
  model.canonical_frame = MeanRoot(frames);
}

}  // namespace

bool IsGaussianAvatarPly(const std::string& path) {
  return PlyReader(path).Has("vertex", kBinding);
}

AvatarModel ReadGaussianAvatar(const std::string& path,
                               const FlameModel& flame,
                               const std::string& data) {
  AvatarModel model;
  model.has_vhap_teeth = HasFlameTopology(flame);
  const FlameModel own = FlameOf(model, flame);
  const size_t count = own.faces.size();
  model.embedding.triangle =
      ReadFaces(path, count, "one of " + flame.name + "'s " + std::to_string(count) + " faces");
  model.gaussians = ReadPly(path);
  FindDegrees(model.gaussians);
  model.embedding.barycentric.assign(model.size(), {1.0f / 3, 1.0f / 3});
  model.embedding.rigid = true;
  model.color_frame = ColorFrame::kWorld;
  model.flame_name = flame.name;
  model.flame_sha256 = flame.sha256;
  model.flame_file = flame.file;
  SetSubject(LoadDrivingSequence(SubjectOf(path, data)), own, model);
  AttachMesh(model, own);
  return model;
}

std::string SummarizeGaussianAvatar(const std::string& path) {
  const Buffer<int32_t> faces =
      ReadFaces(path, std::numeric_limits<int32_t>::max(), "a whole number");
  const Gaussians g = ReadPly(path);
  const std::set<int32_t> used(faces.begin(), faces.end());
  std::string text =
      "GaussianAvatars' avatar: " + std::to_string(g.size()) + " Gaussians, SH degree " +
      std::to_string(g.degree) + ", on " + std::to_string(used.size()) + " faces" +
      (used.empty() ? "" : ", the last of them " + std::to_string(*used.rbegin())) + "\n";
  const fs::path beside = fs::path(path).parent_path() / "flame_param.npz";
  if (!fs::exists(beside)) return text + "without the subject's flame_param.npz\n";
  const TrackedVideo track = LoadDrivingSequence(beside.string());
  return text + "flame_param.npz: " + std::to_string(track.shape.size()) + " shape coefficients, " +
         std::to_string(track.test.size()) + " frames of " +
         std::to_string(track.test.at(0).params.expression.size()) + " expression coefficients, " +
         (track.static_offset.empty() ? "no" : "a") + " static offset\n";
}

}  // namespace cosplat

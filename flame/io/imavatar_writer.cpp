#include "flame/io/imavatar_writer.h"

#include <algorithm>

#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

// The layout's mesh is the model's, enlarged by this factor.
constexpr float kImavatarScale = 4;

// In OpenGL's camera axes and for the enlarged mesh: rows 1 and 2 change sign, the translation is
// scaled.
Json WorldMatrix(const Camera& camera) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    const float sign = r == 0 ? 1.0f : -1.0f;
    rows.push_back({sign * camera.rotation[3 * r],
                    sign * camera.rotation[3 * r + 1],
                    sign * camera.rotation[3 * r + 2],
                    sign * kImavatarScale * camera.translation[r]});
  }
  return rows;
}

// The layout has no translation of the head: it is the camera's.
Camera CameraAboutHead(const TrackedFrame& frame) {
  Camera camera = frame.camera;
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k)
      camera.translation[r] += camera.rotation[3 * r + k] * frame.params.translation[k];
  return camera;
}

Json FrameOfTrack(const TrackedFrame& frame, const std::array<float, 4>& box) {
  Json pose = Json::array();
  for (const auto& joint : frame.params.pose)
    for (float x : joint) pose.push_back(x);
  return {{"file_path", "./image/" + frame.name},
          {"world_mat", WorldMatrix(CameraAboutHead(frame))},
          {"expression", frame.params.expression},
          {"pose", pose},
          {"bbox", box}};
}

}  // namespace

std::array<float, 4> ImavatarBox(const Image8& mask) {
  int x0 = mask.width, y0 = mask.height, x1 = 0, y1 = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (mask.at(x, y, 0) == 0) continue;
      x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
      y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    }
  auto norm = [](int p, int size) { return 2.0f * float(p) / float(size) - 1; };
  return {norm(x0, mask.width), norm(y0, mask.height), norm(x1, mask.width), norm(y1, mask.height)};
}

TrackedVideo TrackOf(const FlameModel& model) {
  TrackedVideo track;
  track.model_vertices = model.own_vertex_count();
  if (!model.landmarks.empty()) track.model_sha256 = model.sha256;
  return track;
}

void WriteImavatarTrack(const std::string& folder,
                        const TrackedVideo& track,
                        const std::vector<std::array<float, 4>>& boxes,
                        int test_frames) {
  const Camera& lens = track.train.at(0).camera;
  const float width = float(lens.width), height = float(lens.height);
  const bool eyelids = TracksEyelids(track);
  Json json{{"intrinsics", {-lens.fx / width, lens.fy / height, lens.cx / width, lens.cy / height}},
            {"shape_params", track.shape},
            {"frames", Json::array()}};
  if (track.model_vertices > 0) json["vertices"] = track.model_vertices;
  if (!track.model_sha256.empty()) json["model_sha256"] = track.model_sha256;
  if (!track.static_offset.empty()) json["static_offset"] = track.static_offset;
  if (test_frames >= 0) json["test_frames"] = test_frames;
  for (size_t f = 0; f < track.train.size(); ++f) {
    json["frames"].push_back(FrameOfTrack(track.train[f], boxes.at(f)));
    if (eyelids) json["frames"].back()["eyelids"] = track.train[f].params.eyelids;
  }
  WriteFileAtomically(folder + "/flame_params.json", json.dump(1) + "\n");
}

}  // namespace cosplat

#include "avatar/train/virtual_faces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "splat/base/rng.h"
#include "splat/media/signed_distance.h"

namespace cosplat {
namespace {

// How far the jaw is open at most, radians; and how the expression differs from the frame's,
// standard deviations.
constexpr float kJaw = 0.3f, kExpression = 0.6f;
constexpr size_t kCandidates = 4;  // per face that is wanted
// A mouth that is open as wide as in this share of the frames, and somewhat more, is known.
constexpr float kOpenShare = 0.02f, kBeyondOpen = 1.2f;
constexpr size_t kMeasuredFrames = 100;
constexpr int kMeasuredSide = 256;  // px
constexpr float kLips = 0.008f;     // metres around the open mouth, for a scale of 1

Camera AtMost(const Camera& camera, int side) {
  const float scale = std::min(1.0f, float(side) / float(std::max(camera.width, camera.height)));
  return camera.Resized(std::max(1, int(scale * float(camera.width))),
                        std::max(1, int(scale * float(camera.height))));
}

// How far each pixel that shows the inside of the mouth is from the lips, metres; elsewhere not
// above 0.
template <class IsInside>
Image FromLips(const std::vector<MeshPixel>& mesh,
               const IsInside& is_inside,
               const Camera& camera) {
  Image8 mask(camera.width, camera.height, 1);
  double depth = 0;
  size_t count = 0;
  for (size_t i = 0; i < mesh.size(); ++i) {
    if (mesh[i].face < 0 || !is_inside(mesh[i])) continue;
    mask.data[i] = 255;
    depth += mesh[i].depth;
    ++count;
  }
  if (count == 0) return Image(camera.width, camera.height, 1);
  Image from = SignedDistance(mask, 128);
  for (float& x : from.data) x *= -float(depth / double(count)) / camera.fx;
  return from;
}

// Of faces as they look from cameras: how far the middle of the open mouth is from the lips,
// metres.
std::vector<float> HowOpen(const FlameModel& flame,
                           AvatarPoser& poser,
                           const std::vector<VirtualFace>& faces,
                           const std::vector<Camera>& cameras) {
  std::vector<float> open(faces.size());
  std::vector<std::vector<float>> vertices(faces.size());
  for (size_t i = 0; i < faces.size(); ++i) poser.Forward(faces[i].params, vertices[i]);
  tbb::parallel_for(size_t(0), faces.size(), [&](size_t i) {
    const Camera camera = AtMost(cameras[faces[i].source], kMeasuredSide);
    const auto is_inside = [&](const MeshPixel& at) {
      return flame.faces[size_t(at.face)][0] >= flame.own_vertex_count();
    };
    const Image from = FromLips(DrawMesh(vertices[i], flame.faces, camera), is_inside, camera);
    open[i] = *std::max_element(from.data.begin(), from.data.end());
  });
  return open;
}

// The k-th of `count`, spread over the track.
VirtualFace Candidate(const FlameModel& flame,
                      const std::vector<AvatarPoser::Parameters>& track,
                      size_t k,
                      size_t count,
                      Rng& rng) {
  const size_t source = k * track.size() / count;
  VirtualFace face{source, track[source]};
  const size_t without_lids = size_t(flame.expression_count - (flame.has_eyelids ? 2 : 0));
  face.params.expression.resize(size_t(flame.expression_count));
  for (size_t e = 0; e < without_lids; ++e) face.params.expression[e] += kExpression * rng.Normal();
  float& jaw = face.params.pose[2][0];
  jaw += std::max(0.0f, kJaw - jaw) * rng.Uniform();
  return face;
}

}  // namespace

VirtualFaces ChooseVirtualFaces(const FlameModel& flame,
                                AvatarPoser& poser,
                                const std::vector<AvatarPoser::Parameters>& track,
                                const std::vector<Camera>& cameras,
                                size_t count) {
  if (flame.mouth.bowl == 0) return {};
  std::vector<VirtualFace> frames, candidates;
  for (size_t i = 0; i < track.size(); i += 1 + (track.size() - 1) / kMeasuredFrames)
    frames.push_back({i, track[i]});
  std::vector<float> seen = HowOpen(flame, poser, frames, cameras);
  std::sort(seen.begin(), seen.end());
  VirtualFaces chosen;
  chosen.known = kBeyondOpen * seen[size_t((1 - kOpenShare) * float(seen.size() - 1))];
  Rng rng{5};
  const size_t total = kCandidates * count;
  for (size_t k = 0; k < total; ++k) candidates.push_back(Candidate(flame, track, k, total, rng));
  const std::vector<float> open = HowOpen(flame, poser, candidates, cameras);
  std::vector<VirtualFace> wide;
  for (size_t k = 0; k < total; ++k)
    if (open[k] > chosen.known) wide.push_back(std::move(candidates[k]));
  const size_t kept = std::min(count, wide.size());
  for (size_t k = 0; k < kept; ++k) chosen.faces.push_back(std::move(wide[k * wide.size() / kept]));
  return chosen;
}

std::optional<TrainFrame> ToVirtualFace(const MeshInFrame& source,
                                        const std::vector<float>& vertices,
                                        float known,
                                        const PaintedMesh& painted) {
  const Camera& camera = source.frame->camera;
  const FrameOnMesh shown(source, painted.faces(), painted.scale());
  const std::vector<MeshPixel> mesh = DrawMesh(vertices, painted.faces(), camera);
  const Image from_lips = FromLips(
      mesh, [&](const MeshPixel& at) { return painted.IsInMouth(at); }, camera);
  const float open = *std::max_element(from_lips.data.begin(), from_lips.data.end());
  if (!(open > known)) return {};
  TrainFrame frame;
  frame.camera = camera;
  frame.target = Image8(camera.width, camera.height, 4, 255);
  frame.ignored = Image8(camera.width, camera.height, 1, 255);
  for (size_t i = 0; i < mesh.size(); ++i) {
    const MeshPixel& at = mesh[i];
    const float from = from_lips.data[i];
    if (at.face < 0 || from < -kLips * painted.scale()) continue;
    const bool inside = painted.IsInMouth(at);
    if (inside && (from <= known || !painted.IsBehindTeeth(at))) continue;
    const math::Vec3<float> color =
        inside ? painted.ColorAt(at) : painted.ColorIn(source, shown, at);
    for (int k = 0; k < 3; ++k) frame.target.data[4 * i + size_t(k)] = ToByte(color[k]);
    frame.ignored.data[i] = 0;
  }
  return frame;
}

}  // namespace cosplat

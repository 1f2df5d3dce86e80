#include "avatar/train/virtual_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "avatar/math/turn.h"
#include "splat/base/median.h"

namespace cosplat {
namespace {

using math::Mat3;
using math::Vec3;

constexpr float kDegree = std::numbers::pi_v<float> / 180;

// A direction that this share of the frames see the head from, to within an angle, is known: the
// farther apart the frames' directions are (their median angle from the mean), the better they show
// the head's shape, and the farther it can be trusted beyond them.
constexpr float kKnownShare = 0.02f, kKnownAngle = 12 * kDegree, kKnownPerSpread = 2.5f;
constexpr float kBeyondFilmed = 0.02f;  // share of the frames beyond either end of FilmedFrom
// Sources are chosen from the nearest ones.
constexpr float kNearest = 0.25f;
constexpr float kSide = 90 * kDegree, kBehindShare = 0.25f, kPitch = 20 * kDegree;

// The k-th point of a sequence that fills a cube evenly, in [0, 1) (Roberts 2018: powers of the
// root of x^4 = x + 1).
float Spread(size_t k, int axis) {
  constexpr std::array<double, 3> kSteps{
      0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const double x = double(k) * kSteps[size_t(axis)];
  return float(x - std::floor(x));
}

// To both sides alike, the given share of them behind.
float YawAt(float x) {
  const float side = x < 0.5f ? -1.0f : 1.0f, u = 2 * x - (x < 0.5f ? 0.0f : 1.0f);
  return side * (u < kBehindShare ? kSide + (std::numbers::pi_v<float> - kSide) * u / kBehindShare
                                  : kSide * (u - kBehindShare) / (1 - kBehindShare));
}

// Where a camera is, seen from the head.
struct HeadDirection {
  float yaw = 0, pitch = 0;  // radians, to the head's left and upwards

  Vec3<float> unit() const {
    return {std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch)};
  }
};

HeadDirection DirectionOf(const HeadInFrame& frame) {
  const Vec3<float> d = math::Normalize(math::TransposeTimes(
      frame.world_from_head, math::ToVec3(frame.camera.Center()) - frame.center));
  return {std::atan2(d.x, d.z), std::asin(std::clamp(d.y, -1.0f, 1.0f))};
}

Mat3<float> Turn(const Vec3<float>& axis, float angle) {
  return math::RotationOf(
      math::QuatOfAxisAngle(std::array<float, 3>{axis.x * angle, axis.y * angle, axis.z * angle}));
}

// Median angle from their mean, radians.
float SpreadOf(const std::vector<Vec3<float>>& directions) {
  Vec3<float> sum{0, 0, 0};
  for (const Vec3<float>& d : directions) sum += d;
  std::vector<float> angles;
  for (const Vec3<float>& d : directions) {
    const Vec3<float> across = math::Cross(d, sum);
    angles.push_back(std::atan2(std::sqrt(math::Dot(across, across)), math::Dot(d, sum)));
  }
  return Median(angles);
}

// The frame's camera, carried around the head.
Camera Around(const HeadInFrame& frame, const HeadDirection& to) {
  const HeadDirection from = DirectionOf(frame);
  const Vec3<float> up = frame.world_from_head * Vec3<float>{0, 1, 0};
  const Vec3<float> across =
      frame.world_from_head * Vec3<float>{std::cos(from.yaw), 0, -std::sin(from.yaw)};
  const Mat3<float> turn = Turn(up, to.yaw - from.yaw) * Turn(across, from.pitch - to.pitch);
  Camera camera = frame.camera;
  for (size_t r = 0; r < 3; ++r) {
    const Vec3<float> before = math::ToVec3(&frame.camera.rotation[3 * r]), after = turn * before;
    for (int k = 0; k < 3; ++k) camera.rotation[3 * r + size_t(k)] = after[k];
    camera.translation[r] += math::Dot(before - after, frame.center);
  }
  return camera;
}

}  // namespace

FilmedFrom FilmedFromOf(const std::vector<HeadInFrame>& frames) {
  std::vector<float> yaw, pitch;
  for (const HeadInFrame& frame : frames) {
    const HeadDirection d = DirectionOf(frame);
    yaw.push_back(d.yaw), pitch.push_back(d.pitch);
  }
  const auto range = [](std::vector<float>& angles) -> std::array<float, 2> {
    std::sort(angles.begin(), angles.end());
    const size_t beyond = size_t(kBeyondFilmed * float(angles.size()));
    return {angles[beyond], angles[angles.size() - 1 - beyond]};
  };
  return {range(yaw), range(pitch), {}};
}

std::vector<VirtualView> ChooseVirtualViews(const std::vector<HeadInFrame>& frames, size_t count) {
  std::vector<Vec3<float>> seen_from;
  for (const HeadInFrame& frame : frames) seen_from.push_back(DirectionOf(frame).unit());
  const float known = kKnownAngle + kKnownPerSpread * SpreadOf(seen_from);
  const size_t few = std::min(size_t(kKnownShare * float(frames.size())), frames.size() - 1);
  std::vector<VirtualView> views;
  for (size_t k = 1; k <= count; ++k) {
    const HeadDirection to{YawAt(Spread(k, 0)), (2 * Spread(k, 1) - 1) * kPitch};
    std::vector<std::pair<float, size_t>> by_angle;  // minus the cosine, frame
    for (size_t i = 0; i < frames.size(); ++i)
      by_angle.push_back({-math::Dot(seen_from[i], to.unit()), i});
    const auto nearest = [&](size_t place) {
      const auto at = by_angle.begin() + std::ptrdiff_t(place);
      std::nth_element(by_angle.begin(), at, by_angle.end());
      return *at;
    };
    if (-nearest(few).first > std::cos(known)) continue;
    const size_t source = nearest(size_t(Spread(k, 2) * kNearest * float(frames.size()))).second;
    views.push_back({source, Around(frames[source], to)});
  }
  return views;
}

TrainFrame ToVirtualView(const VirtualView& view,
                         const MeshInFrame& source,
                         const PaintedMesh& painted) {
  const MeshInFrame with_hair = painted.WithHair(source);
  const FrameOnMesh shown(with_hair, painted.faces(), painted.scale());
  const Camera& camera = view.camera;
  const std::vector<MeshPixel> mesh = DrawMesh(with_hair.vertices, painted.faces(), camera);
  TrainFrame frame;
  frame.camera = camera;
  frame.target = Image8(camera.width, camera.height, 4);
  frame.ignored = painted.BeyondMesh(with_hair, mesh, camera);
  for (size_t i = 0; i < mesh.size(); ++i) {
    const MeshPixel& at = mesh[i];
    if (at.face < 0) continue;
    const Vec3<float> color = painted.ColorIn(with_hair, shown, at);
    for (int k = 0; k < 3; ++k) frame.target.data[4 * i + size_t(k)] = ToByte(color[k]);
    frame.target.data[4 * i + 3] = ToByte(255 * painted.InFrameAt(at));
  }
  return frame;
}

}  // namespace cosplat

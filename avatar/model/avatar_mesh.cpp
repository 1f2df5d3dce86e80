#include "avatar/model/avatar_mesh.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/frame.h"
#include "avatar/math/turn.h"
#include "avatar/model/bust.h"
#include "avatar/model/place_bust.h"
#include "flame/eyelids.h"
#include "flame/math/rodrigues.h"
#include "flame/mouth.h"
#include "flame/topology.h"
#include "flame/vhap_teeth.h"
#include "splat/device/for_each.h"
#include "splat/math/quat.h"

namespace cosplat {
namespace {

using math::AxisAngleOf;
using math::Quat;
using math::QuatOfAxisAngle;
using math::Vec3;

// The sheet, relative to the neck's opening and in units of the neck's mean radius: about 60 cm
// across and 40 cm down for an adult. Its exact shape matters little, because Gaussians walk on it
// and can move away from it along its normal.
constexpr int kColumns = 40, kRows = 20;
constexpr float kHalfWidth = 5.5f;  // of the shoulders
constexpr float kHeight = 6.5f;     // from the collar down
constexpr float kSlope = 1.6f;      // distance of the shoulders' ends below the collar
constexpr float kBulge = 1.8f;      // distance of the chest in front of its sides
constexpr float kOverlap = 0.4f;    // height of the collar above the neck's rim

struct NeckRim {
  Vec3<float> center{0, 0, 0};
  float radius = 0;
};

// The lowest boundary loop (FLAME's axes: y up).
NeckRim FindNeckRim(const FlameModel& flame, const std::vector<float>& vertices) {
  const MeshTopology topology = BuildTopology(flame.name, flame.faces, flame.vertex_count);
  NeckRim lowest;
  lowest.center.y = 1e30f;
  for (const std::vector<int32_t>& loop : topology.boundary_loops) {
    NeckRim rim;
    for (const int32_t v : loop)
      rim.center += Vec3<float>{vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]} *
                    (1.0f / float(loop.size()));
    for (const int32_t v : loop)
      rim.radius += std::hypot(vertices[3 * v] - rim.center.x, vertices[3 * v + 2] - rim.center.z) /
                    float(loop.size());
    if (rim.center.y < lowest.center.y) lowest = rim;
  }
  return lowest;
}

// Appends the sheet to the head's canonical mesh.
void AppendBust(const FlameModel& flame, CanonicalMesh& mesh) {
  const NeckRim rim = FindNeckRim(flame, mesh.vertices);
  const int first = int(mesh.vertices.size() / 3);
  for (int r = 0; r <= kRows; ++r)
    for (int c = 0; c <= kColumns; ++c) {
      const float across = 2.0f * c / kColumns - 1, down = float(r) / kRows;
      const float top = kOverlap - kSlope * across * across;
      mesh.vertices.push_back(rim.center.x + rim.radius * kHalfWidth * across);
      mesh.vertices.push_back(rim.center.y + rim.radius * (top - kHeight * down));
      mesh.vertices.push_back(rim.center.z + rim.radius * kBulge * (0.5f - across * across));
    }
  for (int r = 0; r < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) {
      const int32_t a = first + r * (kColumns + 1) + c, b = a + 1, d = a + kColumns + 1, e = d + 1;
      mesh.faces.push_back({a, d, e});  // counter-clockwise seen from the front
      mesh.faces.push_back({a, e, b});
    }
}

CanonicalMesh HeadMesh(const FlameModel& flame,
                       const std::vector<float>& shape,
                       const std::vector<float>& static_offset) {
  CanonicalMesh mesh;
  mesh.faces = flame.faces;
  FlamePoser<float>(flame, shape, static_offset).Forward({}, mesh.vertices);
  return mesh;
}

// The position of FLAME's root joint at rest.
Vec3<float> RootJoint(const FlameModel& flame,
                      const std::vector<float>& shape,
                      const std::vector<float>& static_offset) {
  const CanonicalMesh mesh = HeadMesh(flame, shape, static_offset);
  Vec3<float> root{0, 0, 0};
  for (int v = 0; v < flame.vertex_count; ++v)
    root += Vec3<float>{mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]} *
            flame.joint_regressor[v];
  return root;
}

}  // namespace

FlameModel FlameOf(const AvatarModel& avatar, FlameModel flame) {
  if (avatar.has_mouth) flame = WithMouth(std::move(flame));
  if (avatar.has_vhap_teeth) flame = WithVhapTeeth(std::move(flame));
  return avatar.has_eyelids ? WithEyelids(std::move(flame)) : flame;
}

CanonicalMesh MakeCanonicalMesh(const FlameModel& flame,
                                const std::vector<float>& shape,
                                const std::vector<float>& static_offset,
                                const std::optional<Bust>& bust,
                                const std::optional<FlameParams>& frame) {
  CanonicalMesh mesh = HeadMesh(flame, shape, static_offset);
  if (bust) AppendBust(flame, mesh);
  if (!frame) return mesh;
  AvatarPoser poser(flame, shape, static_offset, bust);
  poser.Forward(poser.ParametersFor(*frame), mesh.vertices);
  return mesh;
}

AvatarPoser::AvatarPoser(const FlameModel& flame,
                         const std::vector<float>& shape,
                         const std::vector<float>& static_offset,
                         const std::optional<Bust>& bust)
    : poser_(flame, shape, static_offset), flame_vertices_(flame.vertex_count), bust_(bust) {
  if (!bust) return;
  const CanonicalMesh mesh = MakeCanonicalMesh(flame, shape, static_offset, bust);
  for (size_t i = 3 * flame_vertices_; i < mesh.vertices.size(); i += 3)
    for (int r = 0; r < 3; ++r)
      mean_bust_.push_back(bust->rotation[3 * r] * mesh.vertices[i] +
                           bust->rotation[3 * r + 1] * mesh.vertices[i + 1] +
                           bust->rotation[3 * r + 2] * mesh.vertices[i + 2] + bust->translation[r]);
  const float* collar = &mean_bust_[3 * (kColumns / 2)];
  bust_pivot_ = {collar[0], collar[1], collar[2]};
}

AvatarPoser::Parameters AvatarPoser::ParametersFor(const FlameParams& params) const {
  Parameters parameters;
  ParametersFor(params, parameters);
  return parameters;
}

void AvatarPoser::ParametersFor(const FlameParams& params, Parameters& parameters) const {
  const size_t max = poser_.model().expression_count;
  const auto begin = params.expression.begin();
  parameters.expression.assign(begin, begin + std::min(params.expression.size(), max));
  parameters.pose = params.pose;
  parameters.translation = params.translation;
  parameters.bust = bust_ ? PoseOfBust(*bust_, params) : kMeanBustPose;
}

void AvatarPoser::Forward(const Parameters& parameters, std::vector<float>& vertices) {
  poser_.Forward(parameters, vertices, cache_);
  vertices.resize(3 * vertex_count());
  ForEach(mean_bust_.size() / 3,
          HostStream(),
          PlaceBust{mean_bust_, bust_pivot_, &parameters.bust, &vertices[3 * flame_vertices_]});
}

AvatarPoser::Parameters AvatarPoser::Backward(const Parameters& parameters,
                                              View<const float> d_vertices) {
  return {poser_.Backward(
      parameters, {d_vertices.begin(), d_vertices.begin() + 3 * flame_vertices_}, cache_)};
}

HeadPlace PlaceOfHead(View<const float> vertices, const std::array<float, 3>& root) {
  HeadPlace place;
  place.world_from_head = flame_math::Rodrigues(math::ToVec3(root));
  Vec3<float> min{1e30f, 1e30f, 1e30f}, max{-1e30f, -1e30f, -1e30f};
  for (size_t i = 0; i + 2 < vertices.size(); i += 3) {
    const Vec3<float> p = math::TransposeTimes(
        place.world_from_head, Vec3<float>{vertices[i], vertices[i + 1], vertices[i + 2]});
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  place.center = place.world_from_head * ((min + max) * 0.5f);
  place.extent = std::max(max.x - min.x, max.y - min.y);
  return place;
}

FlameParams MeanRoot(const std::vector<FlameParams>& frames) {
  Quat<float> sum{0, 0, 0, 0}, first{1, 0, 0, 0};
  FlameParams mean;
  for (size_t i = 0; i < frames.size(); ++i) {
    const Quat<float> q = QuatOfAxisAngle(frames[i].pose[0]);
    if (i == 0) first = q;
    sum = sum + q * (Dot(q, first) < 0 ? -1.0f : 1.0f);
    for (int k = 0; k < 3; ++k)
      mean.translation[k] += frames[i].translation[k] / float(frames.size());
  }
  mean.pose[0] = AxisAngleOf(math::Normalize(sum));
  return mean;
}

std::vector<float> HeadTurns(const std::vector<FlameParams>& frames) {
  std::vector<FlameParams> heads(frames.size());
  for (size_t i = 0; i < frames.size(); ++i)
    heads[i].pose[0] = AxisAngleOf(
        math::Multiply(QuatOfAxisAngle(frames[i].pose[0]), QuatOfAxisAngle(frames[i].pose[1])));
  const Quat<float> back = math::Conjugate(QuatOfAxisAngle(MeanRoot(heads).pose[0]));
  std::vector<float> turns;
  for (const FlameParams& head : heads) {
    const Quat<float> turn = math::Multiply(QuatOfAxisAngle(head.pose[0]), back);
    turns.push_back(2 * std::acos(std::min(std::abs(turn.w), 1.0f)));
  }
  return turns;
}

std::vector<FlameParams> Retarget(std::vector<FlameParams> frames, const FlameParams& rest) {
  const FlameParams mean = MeanRoot(frames);
  const Quat<float> from = math::Conjugate(QuatOfAxisAngle(mean.pose[0]));
  const Quat<float> to = QuatOfAxisAngle(rest.pose[0]);
  for (FlameParams& frame : frames) {
    const Quat<float> turn = math::Multiply(QuatOfAxisAngle(frame.pose[0]), from);
    frame.pose[0] = AxisAngleOf(math::Multiply(turn, to));
    for (int k = 0; k < 3; ++k) frame.translation[k] += rest.translation[k] - mean.translation[k];
  }
  return frames;
}

void PutOnRest(const FlameParams& rest, FlameParams& frame) {
  for (int k = 0; k < 3; ++k) frame.translation[k] += rest.translation[k];
  if (rest.pose[0] == std::array<float, 3>{}) return;  // keeps the rotation bit-identical
  const Quat<float> turn = QuatOfAxisAngle(frame.pose[0]);
  frame.pose[0] = AxisAngleOf(math::Multiply(turn, QuatOfAxisAngle(rest.pose[0])));
}

Bust MeanBust(const FlameModel& flame,
              const std::vector<float>& shape,
              const std::vector<float>& static_offset,
              const std::vector<FlameParams>& frames) {
  const Vec3<float> root = RootJoint(flame, shape, static_offset);
  const FlameParams mean = MeanRoot(frames);
  const math::Mat3<float> rotation = math::RotationOf(QuatOfAxisAngle(mean.pose[0]));
  const Vec3<float> offset = root - rotation * root;
  Bust bust;
  std::copy(rotation.m, rotation.m + 9, bust.rotation.begin());
  bust.translation = {offset.x + mean.translation[0],
                      offset.y + mean.translation[1],
                      offset.z + mean.translation[2]};
  return bust;
}

FlameParams RestRoot(const AvatarModel& avatar, const FlameModel& flame) {
  FlameParams rest;
  if (avatar.bust) {
    math::Mat3<float> rotation;
    std::copy(avatar.bust->rotation.begin(), avatar.bust->rotation.end(), rotation.m);
    const Vec3<float> root = RootJoint(flame, avatar.shape, avatar.static_offset);
    const Vec3<float> offset = rotation * root - root;
    const std::array<float, 3>& t = avatar.bust->translation;
    rest.pose[0] = AxisAngleOf(math::QuatOfRotation(rotation));
    rest.translation = {t[0] + offset.x, t[1] + offset.y, t[2] + offset.z};
  } else if (avatar.canonical_frame) {
    rest.pose[0] = avatar.canonical_frame->pose[0];
    rest.translation = avatar.canonical_frame->translation;
  }
  return rest;
}

}  // namespace cosplat

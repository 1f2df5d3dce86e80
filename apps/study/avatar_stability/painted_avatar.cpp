#include "apps/study/avatar_stability/painted_avatar.h"

#include <algorithm>
#include <cmath>

#include "assets/head/shading.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/surface/sample.h"
#include "splat/basis_constants.h"

namespace cosplat {
namespace {

constexpr float kWidth = 0.6f, kThickness = 0.15f;  // standard deviations in units of the spacing
constexpr float kOpacityLogitMean = 2.0f;
constexpr uint64_t kSeed = 4;

// Unit quaternion that rotates z to the unit vector n.
std::array<float, 4> QuatFromZ(const math::Vec3<float>& n) {
  const float w = std::sqrt(std::max(0.0f, 0.5f * (1 + n.z)));
  if (w < 1e-3f) return {0, 1, 0, 0};
  return {w, -n.y / (2 * w), n.x / (2 * w), 0};
}

}  // namespace

AvatarModel PaintedAvatar(const ProceduralHead& head,
                          const std::vector<SurfacePoint>& points,
                          Rng& rng,
                          int degree) {
  AvatarModel avatar;
  avatar.mesh = MakeCanonicalMesh(head.model, {}, {}, {});
  procedural::ShadedPose pose{head.mesh.positions, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  const procedural::HeadShader shader(head, pose, {0, 0, 1});
  const Surface surface(avatar.mesh);
  Gaussians& g = avatar.gaussians;
  g.degree = degree;
  g.Resize(points.size());
  const float dc = BasisConstants(g.basis)[0];
  const float spacing = float(std::sqrt(SurfaceArea(avatar.mesh) / double(points.size())));
  for (const SurfacePoint& p : points) {
    const size_t i = avatar.embedding.triangle.size();
    avatar.embedding.triangle.push_back(p.triangle);
    avatar.embedding.barycentric.push_back(p.barycentric);
    const float b[3] = {
        p.barycentric[0], p.barycentric[1], 1 - p.barycentric[0] - p.barycentric[1]};
    math::Vec3<float> normal{0, 0, 0};
    for (int c = 0; c < 3; ++c)
      normal += surface.vertices()[avatar.mesh.faces[p.triangle][c]].normal * b[c];
    const std::array<float, 4> q = QuatFromZ(math::Normalize(normal));
    const std::array<float, 3> color = shader.Shade({int(p.triangle), {b[0], b[1], b[2]}, false});
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = q[k];
    for (int k = 0; k < 3; ++k) {
      g.at(kScaleLog, i)[k] = std::log(spacing * (k < 2 ? kWidth : kThickness));
      g.at(kColorDc, i)[k] = (color[k] - 0.5f) / dc;
    }
    *g.at(kOpacityLogit, i) = kOpacityLogitMean + 0.5f * rng.Normal();
    for (int k = 0; k < g.width(kColorRest); ++k) g.at(kColorRest, i)[k] = 0.02f * rng.Normal();
  }
  return avatar;
}

AvatarModel PaintedAvatar(const ProceduralHead& head, size_t count, int degree) {
  Rng rng{kSeed};
  const CanonicalMesh mesh = MakeCanonicalMesh(head.model, {}, {}, {});
  const std::vector<SurfacePoint> points = SampleSurface(mesh, count, rng);
  return PaintedAvatar(head, points, rng, degree);
}

}  // namespace cosplat

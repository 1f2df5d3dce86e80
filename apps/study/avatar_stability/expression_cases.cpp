// Expressions far outside any training video: the size of Gaussians, how far they reach, and
// whether the head remains closed.
#include <algorithm>
#include <cmath>

#include "apps/study/avatar_stability/cases.h"
#include "apps/study/avatar_stability/steps.h"
#include "avatar/surface/silhouette.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

using math::Vec3;

constexpr int kMaxSigmas = 6;

// Calls f(params) with each coefficient alone at +-sigmas deviations from the mean.
template <class F>
void ForEachExtremeExpression(int sigmas, const F& f) {
  const ExpressionRange range = RangeOfExpressions();
  for (int k = 0; k < kExpressionCount; ++k)
    for (const float sign : {-1.0f, 1.0f}) {
      FlameParams params;
      params.expression = range.mean;
      params.expression[k] += sign * float(sigmas) * range.deviation[k];
      f(params);
    }
}

// Maximum of `measure(posed)` over the expressions, as a curve over the deviations, for both rules;
// the last point is the form's value. Returns the parameters at which the naive one is largest.
template <class F>
FlameParams MeasureOverExpressions(const StudyHead& head, const F& measure, StabilityCase& c) {
  c.chart.x_name = "deviations from the mean";
  c.chart.y_unit = c.unit;
  c.chart.y_log = true;
  c.chart.curves = {{c.naive.name, {}}, {c.ours.name, {}}};
  BoundBothWays bound(head.avatar);
  FlameParams worst;
  for (int sigmas = 0; sigmas <= kMaxSigmas; sigmas += 2) {
    c.naive.value = c.ours.value = 0;
    ForEachExtremeExpression(sigmas, [&](const FlameParams& params) {
      bound.Pose(head.Vertices(params));
      const double naive = measure(bound.naive.posed);
      if (naive > c.naive.value) worst = params;
      c.naive.value = std::max(c.naive.value, naive);
      c.ours.value = std::max(c.ours.value, measure(bound.ours.posed));
    });
    c.chart.curves[0].points.push_back({double(sigmas), c.naive.value});
    c.chart.curves[1].points.push_back({double(sigmas), c.ours.value});
  }
  return worst;
}

// Pixels whose neighbours within `reach` px are all in the mask.
std::vector<uint8_t> Eroded(const std::vector<uint8_t>& mask, int side, int reach) {
  std::vector<uint8_t> out(mask.size());
  for (int y = reach; y < side - reach; ++y)
    for (int x = reach; x < side - reach; ++x) {
      bool all = true;
      for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) all &= mask[size_t(y + j) * side + x + i] != 0;
      out[size_t(y) * side + x] = all;
    }
  return out;
}

// Cosine of the angle between each face's normal and the direction to the camera.
std::vector<float> FacingOf(const std::vector<float>& vertices,
                            const std::vector<std::array<int32_t, 3>>& faces,
                            const Camera& camera) {
  const std::array<float, 3> eye = camera.Center();
  std::vector<float> facing;
  for (const auto& f : faces) {
    const Vec3<float> a = VertexAt(vertices, f[0]);
    const Vec3<float> out = math::AreaVector(a, VertexAt(vertices, f[1]), VertexAt(vertices, f[2]));
    const Vec3<float> to_eye = Vec3<float>{eye[0], eye[1], eye[2]} - a;
    facing.push_back(Dot(math::Normalize(out), math::Normalize(to_eye)));
  }
  return facing;
}

// Pixels of the parts that clearly face the camera, without their rim.
std::vector<uint8_t> FrontOf(const StudyHead& head,
                             const std::vector<float>& vertices,
                             const std::vector<float>& facing,
                             const Camera& camera) {
  constexpr int kRim = 3;  // px, where alpha has to fall
  constexpr float kPlainly = 0.5f;
  std::vector<std::array<int32_t, 3>> front;
  for (size_t f = 0; f < facing.size(); ++f)
    if (facing[f] > kPlainly) front.push_back(head.avatar.mesh.faces[f]);
  return Eroded(MeshSilhouette(vertices, front, camera), kStudyImage, kRim);
}

}  // namespace

StabilityCase ExpressionSizeCase(const StudyHead& head) {
  StabilityCase c;
  c.key = "expression_size";
  c.title = "Expressions six deviations out: sizes";
  c.what =
      "Each expression coefficient alone, up to six standard deviations from its mean to both "
      "sides, as a driving track may have it. Triangles shrink and stretch many times.";
  c.quantity = "largest growth of a Gaussian since rest";
  c.unit = "times";
  c.bound = 4;
  c.naive.name = "exp(log s A / A0), as released";
  c.ours.name = "s sqrt(A / A0), at most four times";
  c.chart.y_name = "largest growth";
  const PosedGaussians rest = BoundBothWays(head.avatar).ours.posed;
  const auto growth = [&](const PosedGaussians& posed) {
    double max = 0;
    for (size_t i = 0; i < rest.size(); ++i)
      max = std::max(max, double(LargestScale(posed, i) / LargestScale(rest, i)));
    return max;
  };
  const FlameParams worst = MeasureOverExpressions(head, growth, c);
  BoundBothWays bound(head.avatar);
  bound.Pose(head.Vertices(worst));
  c.naive.image = ImageOf(bound.naive, StudyCamera());
  c.ours.image = ImageOf(bound.ours, StudyCamera());
  return c;
}

StabilityCase ExpressionReachCase(const StudyHead& head) {
  StabilityCase c;
  c.key = "expression_reach";
  c.title = "Expressions six deviations out: reach";
  c.what =
      "The same expressions. Where the mesh's own vertices go there is no better place for a "
      "Gaussian; beyond that, three of its standard deviations show how far it reaches.";
  c.quantity = "farthest that a Gaussian reaches from its place at rest";
  c.unit = "mm";
  c.bound = 40;
  c.naive.name = "exp(log s A / A0), as released";
  c.ours.name = "s sqrt(A / A0), at most four times";
  c.chart.y_name = "farthest reach";
  const PosedGaussians rest = BoundBothWays(head.avatar).ours.posed;
  const auto reach = [&](const PosedGaussians& posed) {
    double max = 0;
    for (size_t i = 0; i < rest.size(); ++i) {
      const float *p = &posed.position[3 * i], *q = &rest.position[3 * i];
      const double moved = std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
      max = std::max(max, 1000 * (moved + 3 * double(LargestScale(posed, i))));
    }
    return max;
  };
  MeasureOverExpressions(head, reach, c);
  return c;
}

StabilityCase HolesCase(const StudyHead& head) {
  constexpr float kNothing = -30;  // opacity logit
  StabilityCase c;
  c.key = "holes";
  c.title = "Holes in a stretched face";
  c.what =
      "A grimace stretches cheeks and lips. The back of the head is taken away, so that where "
      "Gaussians do not grow with their triangles the background (green) shows.";
  c.quantity = "least alpha on what faces the camera";
  c.bound = 0.9;
  c.at_least = true;
  c.naive.name = "exp(log s A / A0), as released";
  c.ours.name = "s sqrt(A / A0)";
  const std::vector<float> vertices = head.Vertices(Grimace());
  const Camera camera = StudyCamera();
  const std::vector<float> facing = FacingOf(vertices, head.avatar.mesh.faces, camera);
  const std::vector<uint8_t> front = FrontOf(head, vertices, facing, camera);
  AvatarModel half = head.avatar;
  for (size_t i = 0; i < half.size(); ++i)
    if (facing[half.embedding.triangle[i]] < 0) *half.gaussians.at(kOpacityLogit, i) = kNothing;
  BoundBothWays bound(half);
  bound.Pose(vertices);
  for (const bool is_ours : {false, true}) {
    StabilityForm& form = is_ours ? c.ours : c.naive;
    const RenderedImage image = DrawOver(is_ours ? bound.ours : bound.naive, camera, {0, 1, 0});
    form.value = 1;
    for (size_t p = 0; p < front.size(); ++p)
      if (front[p]) form.value = std::min(form.value, 1.0 - image.transmittance[p]);
    form.image = ToBytes(image.ToImage());
  }
  return c;
}

}  // namespace cosplat

#include "flame/eyelids.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/math/vec.h"

namespace cosplat {
namespace {

constexpr int kLeftEyeJoint = 3, kRightEyeJoint = 4;
constexpr double kDegree = 3.14159265358979323846 / 180;

using Vector = math::Vec3<double>;

// About an eyeball's centre: azimuth towards +x, elevation towards +y, both from +z; radians.
struct Polar {
  double azimuth = 0, elevation = 0, distance = 0;
};
Polar PolarOf(const Vector& v) {
  const double across = std::hypot(v.x, v.z);
  return {std::atan2(v.x, v.z), std::atan2(v.y, across), std::hypot(across, v.y)};
}
Vector VectorOf(const Polar& p) {
  const double across = p.distance * std::cos(p.elevation);
  return {across * std::sin(p.azimuth),
          p.distance * std::sin(p.elevation),
          across * std::cos(p.azimuth)};
}

// Whether the ray from the origin along `to` meets the triangle (Moeller and Trumbore 1997).
bool Meets(const Vector& to, const std::array<Vector, 3>& t) {
  const Vector e1 = t[1] - t[0], e2 = t[2] - t[0], p = Cross(to, e2);
  const double determinant = Dot(e1, p);
  if (determinant == 0) return false;
  const Vector s = -t[0];
  const double u = Dot(s, p) / determinant;
  const Vector q = Cross(s, e1);
  const double v = Dot(to, q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && Dot(e2, q) / determinant > 0;
}

// One eye of the template: the opening of its lids, and how far closing moves a point.
class Eye {
 public:
  Eye(const FlameModel& model, int joint) : model_(model), joint_(joint) {
    Vector min{1e9, 1e9, 1e9}, max{-1e9, -1e9, -1e9};
    for (int v = 0; v < model.vertex_count; ++v) {
      if (!IsEyeball(v)) continue;
      const Vector p = PointOf(v);
      min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
      max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
    }
    radius_ = (max.x - min.x) / 2;
    centre_ = {(min.x + max.x) / 2, (min.y + max.y) / 2, (min.z + max.z) / 2};
    FindOpening();
  }

  // How closing the upper lid moves vertex v, metres.
  Vector Closing(int v) const {
    const Vector from = PointOf(v) - centre_;
    Polar p = PolarOf(from);
    if (IsEyeball(v) || p.distance > kReach * radius_ || from.z < 0) return {};
    const double at = (p.azimuth / kDegree + kMaxAzimuth) / kStep;
    if (at < 0 || at >= double(kColumns - 1)) return {};
    const Gap &a = gaps_[size_t(at)], &b = gaps_[size_t(at) + 1];
    const double t = at - std::floor(at);
    const double bottom = a.bottom + t * (b.bottom - a.bottom), top = a.top + t * (b.top - a.top);
    if (top <= bottom || p.elevation < (bottom + top) / 2) return {};
    // The rim turns all the way; what is above it less and less, up to the brow.
    const double above = std::clamp((p.elevation - top - kRim) / kFade, 0.0, 1.0);
    p.elevation -= kOverlap * (top - bottom) * (1 - above * above * (3 - 2 * above));
    return VectorOf(p) - from;
  }

 private:
  // The opening at an azimuth, elevations; empty (bottom = top) beyond the corners.
  struct Gap {
    double bottom = 0, top = 0;
  };
  static constexpr double kMaxAzimuth = 75, kMaxElevation = 60, kStep = 1;  // degrees
  static constexpr size_t kColumns = size_t(2 * kMaxAzimuth / kStep) + 1;
  static constexpr double kReach = 2;  // in radii of the eyeball: farther skin is no lid
  static constexpr double kRim = 4 * kDegree, kFade = 45 * kDegree;
  static constexpr double kOverlap = 1.08;  // nothing shows between vertices of the rims

  bool IsEyeball(int v) const {
    return model_.skinning_weights[size_t(kFlameJoints * v + joint_)] > 0.5f;
  }
  Vector PointOf(int v) const {
    const float* p = &model_.template_vertices[3 * size_t(v)];
    return {p[0], p[1], p[2]};
  }

  // Scans, for each azimuth, the directions in which no skin is before the eyeball's centre.
  void FindOpening() {
    std::vector<std::array<Vector, 3>> skin;
    for (const std::array<int32_t, 3>& face : model_.faces) {
      std::array<Vector, 3> t;
      bool near = true;
      for (size_t k = 0; k < 3; ++k) {
        t[k] = PointOf(face[k]) - centre_;
        near = near && !IsEyeball(face[k]) && Dot(t[k], t[k]) < 9 * radius_ * radius_;
      }
      if (near) skin.push_back(t);
    }
    const auto open = [&](double azimuth, double elevation) {
      const Vector to = VectorOf({azimuth, elevation, 1});
      return std::none_of(skin.begin(), skin.end(), [&](const auto& t) { return Meets(to, t); });
    };
    bool any = false;
    for (size_t c = 0; c < kColumns; ++c) {
      const double azimuth = (double(c) * kStep - kMaxAzimuth) * kDegree;
      std::vector<double> seen;
      for (double e = -kMaxElevation; e <= kMaxElevation; e += kStep / 2)
        if (open(azimuth, e * kDegree)) seen.push_back(e * kDegree);
      if (seen.empty()) continue;
      gaps_[c] = {seen.front(), seen.back()};
      any = true;
    }
    if (!any || radius_ <= 0)
      throw Error(model_.name, "eyelids", Format("the eye of joint {} is shut", joint_));
  }

  const FlameModel& model_;
  int joint_;
  Vector centre_;
  double radius_ = 0;
  std::array<Gap, kColumns> gaps_{};
};

}  // namespace

FlameModel WithEyelids(FlameModel model) {
  if (model.has_eyelids) return model;
  std::vector<float> directions;
  for (const int joint : {kLeftEyeJoint, kRightEyeJoint}) {
    const Eye eye(model, joint);
    for (int v = 0; v < model.vertex_count; ++v) {
      const Vector d = eye.Closing(v);
      directions.insert(directions.end(), {float(d.x), float(d.y), float(d.z)});
    }
  }
  model.expression_directions.insert(
      model.expression_directions.end(), directions.begin(), directions.end());
  model.expression_count += 2;
  if (!model.expression_names.empty()) {
    model.expression_names.resize(size_t(model.expression_count));
    model.expression_scores.resize(size_t(model.expression_count));
  }
  model.has_eyelids = true;
  return model;
}

void EyelidsToExpression(const FlameModel& model, FlameParams& params) {
  if (!model.has_eyelids) return;
  params.expression.resize(size_t(model.expression_count) - 2);
  params.expression.insert(params.expression.end(), params.eyelids.begin(), params.eyelids.end());
  params.eyelids = {};
}

void EyelidsFromExpression(const FlameModel& model, FlameParams& params) {
  if (!model.has_eyelids) return;
  std::copy_n(params.expression.end() - 2, 2, params.eyelids.begin());
  params.expression.resize(params.expression.size() - 2);
}

}  // namespace cosplat

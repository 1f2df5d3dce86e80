#include "apps/study/stability/naive_render.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/basis_constants.h"
#include "splat/math/blend.h"
#include "splat/math/dcsh.h"

namespace cosplat {
namespace {

using Vec3 = math::Vec3<float>;

math::Pinhole<float> PinholeOf(const Camera& camera) {
  math::Pinhole<float> p;
  std::copy(camera.rotation.begin(), camera.rotation.end(), p.rotation.m);
  p.translation = {camera.translation[0], camera.translation[1], camera.translation[2]};
  p.fx = camera.fx;
  p.fy = camera.fy;
  p.cx = camera.cx;
  p.cy = camera.cy;
  p.width = float(camera.width);
  p.height = float(camera.height);
  return p;
}

Vec3 Row(const float* p) { return {p[0], p[1], p[2]}; }

// R S S^T R^T with the quaternion q / |q|.
math::Sym3<float> UnguardedCovariance(const float* q, const float* scale_log) {
  const float norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const math::Quat<float> unit{q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
  const Vec3 scale{std::exp(scale_log[0]), std::exp(scale_log[1]), std::exp(scale_log[2])};
  const math::Mat3<float> m = math::ScaleColumns(math::RotationOf(unit), scale);
  const auto entry = [&](int r, int c) {
    return m(r, 0) * m(c, 0) + m(r, 1) * m(c, 1) + m(r, 2) * m(c, 2);
  };
  return {entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)};
}

math::ProjectionJacobian<float> JacobianOf(NaiveJacobian kind,
                                           const math::Pinhole<float>& camera,
                                           const Vec3& p) {
  float sx = p.x / p.z, sy = p.y / p.z;
  if (kind == NaiveJacobian::kAboutMiddle) {
    const float limit_x = 1.3f * 0.5f * camera.width / camera.fx;
    const float limit_y = 1.3f * 0.5f * camera.height / camera.fy;
    sx = std::clamp(sx, -limit_x, limit_x);
    sy = std::clamp(sy, -limit_y, limit_y);
  }
  return {camera.fx / p.z, -camera.fx * sx / p.z, camera.fy / p.z, -camera.fy * sy / p.z};
}

Vec3 ColorOf(const Gaussians& g, size_t i, const Vec3& direction) {
  const float *constants = BasisConstants(g.basis), *dc = g.at(kColorDc, i);
  const float* rest = g.at(kColorRest, i);
  if (g.degree == 0) return math::EvaluateColor<0, float>(direction, constants, dc, rest);
  return math::EvaluateColor<1, float>(direction, constants, dc, rest);
}

}  // namespace

float NaiveFootprint::Radius() const {
  const float middle = 0.5f * (covariance.xx + covariance.yy);
  const float root = std::sqrt(std::max(middle * middle - math::Determinant(covariance), 0.0f));
  return 3 * std::sqrt(middle + root);
}

NaiveFootprint NaiveFootprintOf(const Gaussians& g,
                                size_t i,
                                const Camera& camera,
                                NaiveJacobian jacobian) {
  const math::Pinhole<float> pinhole = PinholeOf(camera);
  const Vec3 position = Row(g.at(kPosition, i)), p = math::ToCamera(pinhole, position);
  const math::ImageAxes<float> axes = math::ImageAxesAt(pinhole, JacobianOf(jacobian, pinhole, p));
  const math::Sym3<float> sigma = UnguardedCovariance(g.at(kRotation, i), g.at(kScaleLog, i));
  const Vec3 su = sigma * axes.u, sv = sigma * axes.v;
  NaiveFootprint f;
  f.covariance = {math::Dot(axes.u, su) + kBlurVariance,
                  math::Dot(axes.u, sv),
                  math::Dot(axes.v, sv) + kBlurVariance};
  f.conic = math::Conic(f.covariance);
  const math::Vec2<float> center = math::ProjectPoint(pinhole, p);
  f.x = center.x;
  f.y = center.y;
  f.depth = p.z;
  f.opacity = math::Sigmoid(*g.at(kOpacityLogit, i));
  const std::array<float, 3> eye = camera.Center();
  const Vec3 offset = position - Row(eye.data());
  f.color = ColorOf(g, i, offset * (1 / std::sqrt(math::Dot(offset, offset))));
  return f;
}

std::vector<NaiveFootprint> NaiveFootprints(const Gaussians& gaussians,
                                            const Camera& camera,
                                            NaiveJacobian jacobian) {
  std::vector<NaiveFootprint> footprints;
  for (size_t i = 0; i < gaussians.size(); ++i)
    footprints.push_back(NaiveFootprintOf(gaussians, i, camera, jacobian));
  return footprints;
}

std::vector<uint32_t> DepthOrder(const std::vector<NaiveFootprint>& footprints) {
  std::vector<uint32_t> order(footprints.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return footprints[a].depth < footprints[b].depth;
  });
  return order;
}

Image DrawNaive(const std::vector<NaiveFootprint>& footprints,
                const std::vector<uint32_t>& order,
                int width,
                int height) {
  // Beyond four deviations every alpha is below the limit. NaN footprints are not skipped.
  std::vector<float> reach2;
  for (const NaiveFootprint& f : footprints) reach2.push_back(16.0f / 9 * f.Radius() * f.Radius());
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      math::BlendState<float> state{1, {0, 0, 0}};
      for (const uint32_t i : order) {
        const NaiveFootprint& f = footprints[i];
        const float dx = x + 0.5f - f.x, dy = y + 0.5f - f.y;
        if (dx * dx + dy * dy > reach2[i]) continue;
        const float power =
            -0.5f * (f.conic.xx * dx * dx + f.conic.yy * dy * dy) - f.conic.xy * dx * dy;
        if (power > 0) continue;
        float alpha = f.opacity * std::exp(power);
        if (alpha > kMaxAlpha) alpha = kMaxAlpha;
        if (alpha < kMinAlpha) continue;
        math::BlendBehind(alpha, f.color, state);
        if (state.transmittance < kMinTransmittance) break;
      }
      image.at(x, y, 0) = state.color.x;
      image.at(x, y, 1) = state.color.y;
      image.at(x, y, 2) = state.color.z;
    }
  return image;
}

}  // namespace cosplat

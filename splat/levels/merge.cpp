#include "splat/levels/merge.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "splat/config.h"
#include "splat/math/gaussian.h"

namespace cosplat {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A thinner Gaussian than this share of its length is as good as flat.
constexpr double kThinnest = 1e-6;

Vector3d ScaleOf(const OneGaussian<const float>& g) {
  const float* s = g.values[kScaleLog];
  return {std::exp(double(s[0])), std::exp(double(s[1])), std::exp(double(s[2]))};
}

// Mean area of an ellipsoid's shadow over all directions but for a factor, to a few percent: of the
// three boxes' faces.
double ShadowOf(const Vector3d& scale) {
  return scale[0] * scale[1] + scale[1] * scale[2] + scale[2] * scale[0];
}

Vector3d MeanOf(const OneGaussian<const float>& g) {
  const float* p = g.values[kPosition];
  return {p[0], p[1], p[2]};
}

Matrix3d CovarianceOf(const OneGaussian<const float>& g) {
  const float* q = g.values[kRotation];
  const Vector3d s = ScaleOf(g);
  const auto c = math::Covariance(math::Quat<double>{q[0], q[1], q[2], q[3]},
                                  math::Vec3<double>{s[0], s[1], s[2]});
  Matrix3d m;
  m << c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, c.xz, c.yz, c.zz;
  return m;
}

void WriteShape(const Matrix3d& covariance, double coverage, const OneGaussian<float>& out) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(covariance);
  const double longest = std::sqrt(std::max(axes.eigenvalues()[2], 0.0));
  Vector3d scale;
  for (int i = 0; i < 3; ++i)
    scale[i] = std::max({std::sqrt(std::max(axes.eigenvalues()[i], 0.0)),
                         kThinnest * longest,
                         1e-30});  // of two points
  Matrix3d rotation = axes.eigenvectors();
  if (rotation.determinant() < 0) rotation.col(0) = -rotation.col(0);
  const Eigen::Quaterniond q(rotation);
  float* to = out.values[kRotation];
  to[0] = float(q.w());
  to[1] = float(q.x());
  to[2] = float(q.y());
  to[3] = float(q.z());
  for (int i = 0; i < 3; ++i) out.values[kScaleLog][i] = float(std::log(scale[i]));
  const double opacity = std::min(coverage / ShadowOf(scale), double(kMaxAlpha));
  constexpr double kSmallest = 1e-20;  // its logit is finite
  *out.values[kOpacityLogit] = float(std::log(std::max(opacity, kSmallest) / (1 - opacity)));
}

}  // namespace

double Coverage(const OneGaussian<const float>& g) {
  return math::Sigmoid(double(*g.values[kOpacityLogit])) * ShadowOf(ScaleOf(g));
}

Merged MergeTwo(const OneGaussian<const float>& a,
                const OneGaussian<const float>& b,
                const size_t (&widths)[kAttributeCount],
                const OneGaussian<float>& out) {
  const double of_a = Coverage(a), of_b = Coverage(b);
  const double sum = of_a + of_b;
  const double share = sum > 0 ? of_b / sum : 0.5;
  const Vector3d from = MeanOf(a), apart = MeanOf(b) - from;
  const Vector3d mean = from + share * apart;
  for (int i = 0; i < 3; ++i) out.values[kPosition][i] = float(mean[i]);
  for (const int color : {int(kColorDc), int(kColorRest)})
    for (size_t i = 0; i < widths[color]; ++i)
      out.values[color][i] = float((1 - share) * a.values[color][i] + share * b.values[color][i]);
  const double between = share * (1 - share);
  WriteShape(
      (1 - share) * CovarianceOf(a) + share * CovarianceOf(b) + between * apart * apart.transpose(),
      sum,
      out);
  return {share, between * apart.squaredNorm()};
}

}  // namespace cosplat

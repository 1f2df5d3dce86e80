// Rotations as trackers store them, converted to FLAME's axis-angle vectors.
#pragma once

#include <array>
#include <cmath>

#include "splat/math/vec.h"

namespace cosplat::flame_math {

using math::Mat3;
using math::Vec3;

// The rotation whose first two *rows* are numbers 0-2 and 3-5, made orthonormal one after the other
// (Zhou et al. 2019; PyTorch3D's convention, the paper has columns). False, and `out` is unchanged,
// if a row is zero or not finite or both have one direction.
inline bool RotationFrom6d(const std::array<double, 6>& rows, Mat3<double>& out) {
  Vec3<double> a = math::ToVec3(rows), b = math::ToVec3(rows.data() + 3);
  // Shortens to one; false if what is left of a vector of length `whole` is rounding.
  const auto normalize = [](Vec3<double>& x, double whole) {
    const double length = std::sqrt(math::Dot(x, x));
    for (int i = 0; i < 3; ++i) x[i] /= length;
    return std::isfinite(length) && length > 1e-6 * whole;
  };
  const double length_b = std::sqrt(math::Dot(b, b));
  if (!normalize(a, 0)) return false;
  b -= math::Dot(a, b) * a;
  if (!normalize(b, length_b)) return false;
  const Vec3<double> c = math::Cross(a, b);
  out = {{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z}};
  return true;
}

// The inverse of Rodrigues (flame/math/rodrigues.h): axis times angle, the angle at most pi. Exact
// at every angle, as it goes through the quaternion's largest component (Shepperd 1978).
inline Vec3<double> AxisAngleOf(const Mat3<double>& r) {
  const double trace = r(0, 0) + r(1, 1) + r(2, 2);
  // 4 w^2, 4 x^2, 4 y^2, 4 z^2.
  const std::array<double, 4> squares = {
      1 + trace, 1 + 2 * r(0, 0) - trace, 1 + 2 * r(1, 1) - trace, 1 + 2 * r(2, 2) - trace};
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (squares[i] > squares[largest]) largest = i;
  const Vec3<double> skew = {
      r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};  // 4 w (x, y, z)
  const double root = std::sqrt(squares[largest]);
  double w = 0;
  Vec3<double> v;
  if (largest == 0) {
    w = 0.5 * root;
    for (int i = 0; i < 3; ++i) v[i] = 0.5 * skew[i] / root;
  } else {
    const int k = largest - 1;
    w = 0.5 * skew[k] / root;
    for (int i = 0; i < 3; ++i) v[i] = i == k ? 0.5 * root : 0.5 * (r(k, i) + r(i, k)) / root;
  }
  if (w < 0) {
    w = -w;
    v = -v;
  }
  const double sine = std::sqrt(math::Dot(v, v));
  const double scale = sine > 1e-12 ? 2 * std::atan2(sine, w) / sine : 2;
  return v * scale;
}

}  // namespace cosplat::flame_math

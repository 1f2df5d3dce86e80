// Rotations as trackers store them, converted to FLAME's axis-angle vectors.
#pragma once

#include <array>
#include <cmath>

#include "flame/math/linear.h"

namespace cosplat::flame_math {

// The rotation whose first two *rows* are numbers 0-2 and 3-5, made orthonormal one after the other
// (Zhou et al. 2019; PyTorch3D's convention, the paper has columns). False, and `out` is unchanged,
// if a row is zero or not finite or both have one direction.
inline bool RotationFrom6d(const std::array<double, 6>& rows, Matrix3<double>& out) {
  Vector3<double> a = {rows[0], rows[1], rows[2]}, b = {rows[3], rows[4], rows[5]};
  const auto dot = [](const Vector3<double>& x, const Vector3<double>& y) {
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
  };
  // Shortens to one; false if what is left of a vector of length `whole` is rounding.
  const auto normalize = [&](Vector3<double>& x, double whole) {
    const double length = std::sqrt(dot(x, x));
    for (double& number : x) number /= length;
    return std::isfinite(length) && length > 1e-6 * whole;
  };
  const double length_b = std::sqrt(dot(b, b));
  if (!normalize(a, 0)) return false;
  const double along = dot(a, b);
  for (int i = 0; i < 3; ++i) b[i] -= along * a[i];
  if (!normalize(b, length_b)) return false;
  out = {a[0],
         a[1],
         a[2],
         b[0],
         b[1],
         b[2],
         a[1] * b[2] - a[2] * b[1],
         a[2] * b[0] - a[0] * b[2],
         a[0] * b[1] - a[1] * b[0]};
  return true;
}

// The inverse of Rodrigues (flame/math/rodrigues.h): axis times angle, the angle at most pi. Exact
// at every angle, as it goes through the quaternion's largest component (Shepperd 1978).
inline Vector3<double> AxisAngleOf(const Matrix3<double>& r) {
  const double trace = r[0] + r[4] + r[8];
  // 4 w^2, 4 x^2, 4 y^2, 4 z^2.
  const std::array<double, 4> squares = {
      1 + trace, 1 + 2 * r[0] - trace, 1 + 2 * r[4] - trace, 1 + 2 * r[8] - trace};
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (squares[i] > squares[largest]) largest = i;
  const Vector3<double> skew = {r[7] - r[5], r[2] - r[6], r[3] - r[1]};  // 4 w (x, y, z)
  const double root = std::sqrt(squares[largest]);
  double w = 0;
  Vector3<double> v;
  if (largest == 0) {
    w = 0.5 * root;
    for (int i = 0; i < 3; ++i) v[i] = 0.5 * skew[i] / root;
  } else {
    const int k = largest - 1;
    w = 0.5 * skew[k] / root;
    for (int i = 0; i < 3; ++i)
      v[i] = i == k ? 0.5 * root : 0.5 * (r[3 * k + i] + r[3 * i + k]) / root;
  }
  if (w < 0) {
    w = -w;
    for (double& x : v) x = -x;
  }
  const double sine = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double scale = sine > 1e-12 ? 2 * std::atan2(sine, w) / sine : 2;
  for (double& x : v) x *= scale;
  return v;
}

}  // namespace cosplat::flame_math

// Conversion from axis-angle to rotation matrix and its derivative, exact through the zero angle.
//
// R = I + a K + b (w w^T - s I), with s = |w|^2, K = [w]x, a = sin(t)/t, b = (1 - cos t)/t^2 and
// t = sqrt(s) (Rodrigues 1840). a and b are entire functions of s: below one radian they and their
// derivatives come from their power series, so neither t = 0 nor cancellation can spoil them.
#pragma once

#include "splat/math/vec.h"

namespace cosplat::flame_math {

using math::Cos;
using math::Mat3;
using math::Sin;
using math::Sqrt;
using math::Vec3;

template <class T>
struct RodriguesCoefficients {
  T a, b;      // sin(t)/t and (1 - cos t)/t^2
  T d_a, d_b;  // da/ds and db/ds
};

template <class T>
RodriguesCoefficients<T> RodriguesCoefficientsOf(const T& s) {
  RodriguesCoefficients<T> c;
  if (s < T(1)) {
    // sum (-s)^n / (2n+1)! and sum (-s)^n / (2n+2)!; the tenth term is below 1e-17 for s < 1.
    // Horner from the last term: p <- 1 - p s / (k (k+1)), differentiated along with p.
    c.a = c.b = T(1);
    c.d_a = c.d_b = T(0);
    for (int n = 10; n >= 1; --n) {
      const T ka = T(1.0 / (2.0 * n * (2.0 * n + 1)));
      const T kb = T(1.0 / ((2.0 * n + 1) * (2.0 * n + 2)));
      c.d_a = -ka * (c.a + s * c.d_a);
      c.d_b = -kb * (c.b + s * c.d_b);
      c.a = T(1) - ka * s * c.a;
      c.b = T(1) - kb * s * c.b;
    }
    c.b = c.b * T(0.5);
    c.d_b = c.d_b * T(0.5);
  } else {
    const T t = Sqrt(s);
    const T cosine = Cos(t);
    c.a = Sin(t) / t;
    c.b = (T(1) - cosine) / s;
    c.d_a = (cosine - c.a) / (T(2) * s);
    c.d_b = (c.a * T(0.5) - c.b) / s;
  }
  return c;
}

// w: axis times angle, radians.
template <class T>
Mat3<T> Rodrigues(const Vec3<T>& w) {
  const T s = Dot(w, w);
  const RodriguesCoefficients<T> c = RodriguesCoefficientsOf(s);
  Mat3<T> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = c.b * w[i] * w[j] + (i == j ? T(1) - c.b * s : T(0));
  const Vec3<T> aw = c.a * w;
  r(0, 1) -= aw.z;
  r(0, 2) += aw.y;
  r(1, 0) += aw.z;
  r(1, 2) -= aw.x;
  r(2, 0) -= aw.y;
  r(2, 1) += aw.x;
  return r;
}

// dL/dw given d_r = dL/dR.
template <class T>
Vec3<T> RodriguesVjp(const Vec3<T>& w, const Mat3<T>& d_r) {
  const T s = Dot(w, w);
  const RodriguesCoefficients<T> c = RodriguesCoefficientsOf(s);
  const Vec3<T> skew = {
      d_r(2, 1) - d_r(1, 2), d_r(0, 2) - d_r(2, 0), d_r(1, 0) - d_r(0, 1)};  // dL/d(a w)
  const T trace = d_r(0, 0) + d_r(1, 1) + d_r(2, 2);
  const Vec3<T> dw = d_r * w;
  const Vec3<T> dtw = TransposeTimes(d_r, w);
  const T d_a = Dot(skew, w);
  const T d_b = Dot(dw, w) - s * trace;
  const T d_s = d_a * c.d_a + d_b * c.d_b - c.b * trace;
  Vec3<T> d_w;
  for (int i = 0; i < 3; ++i) d_w[i] = c.a * skew[i] + c.b * (dw[i] + dtw[i]) + T(2) * d_s * w[i];
  return d_w;
}

}  // namespace cosplat::flame_math

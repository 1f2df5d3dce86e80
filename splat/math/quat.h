// Quaternions, wxyz, Hamilton convention; R(q) rotates a column vector: p_out = R(q) p_in.
#if defined(COSPLAT_SPLAT_MATH_QUAT_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_QUAT_H_
#undef COSPLAT_SPLAT_MATH_QUAT_H_
#else
#define COSPLAT_SPLAT_MATH_QUAT_H_
#endif

#include "splat/math/vec.h"

COSPLAT_MATH_BEGIN

template <class T>
struct Quat {
  T w, x, y, z;
};

template <class T>
COSPLAT_HD T Dot(const Quat<T>& a, const Quat<T>& b) {
  return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
COSPLAT_HD Quat<T> operator+(const Quat<T>& a, const Quat<T>& b) {
  return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
COSPLAT_HD Quat<T> operator*(const Quat<T>& a, T s) {
  return {a.w * s, a.x * s, a.y * s, a.z * s};
}

// Squared norms below this count as "no rotation": the identity, with zero derivative.
constexpr float kQuatMinNorm2 = 1e-16f;

template <class T>
COSPLAT_HD Quat<T> Normalize(const Quat<T>& q) {
  const T n2 = Dot(q, q);
  const auto ok = n2 > T(kQuatMinNorm2);
  const T inv = T(1) / Sqrt(Select(ok, n2, T(1)));
  return {Select(ok, q.w * inv, T(1)),
          Select(ok, q.x * inv, T(0)),
          Select(ok, q.y * inv, T(0)),
          Select(ok, q.z * inv, T(0))};
}
template <class T>
COSPLAT_HD Quat<T> NormalizeVjp(const Quat<T>& q, const Quat<T>& d) {
  const T n2 = Dot(q, q);
  const auto ok = n2 > T(kQuatMinNorm2);
  const T inv = Select(ok, T(1) / Sqrt(Select(ok, n2, T(1))), T(0));
  const Quat<T> u = q * inv;
  const T s = Dot(u, d);
  return {
      (d.w - u.w * s) * inv, (d.x - u.x * s) * inv, (d.y - u.y * s) * inv, (d.z - u.z * s) * inv};
}

// Hamilton product: R(a b) = R(a) R(b).
template <class T>
COSPLAT_HD Quat<T> Multiply(const Quat<T>& a, const Quat<T>& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
          a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
template <class T>
COSPLAT_HD Quat<T> Conjugate(const Quat<T>& q) {
  return {q.w, -q.x, -q.y, -q.z};
}
// d_a = d conj(b), d_b = conj(a) d, for any norms (the product is bilinear).
template <class T>
COSPLAT_HD void MultiplyVjp(
    const Quat<T>& a, const Quat<T>& b, const Quat<T>& d, Quat<T>& d_a, Quat<T>& d_b) {
  d_a = d_a + Multiply(d, Conjugate(b));
  d_b = d_b + Multiply(Conjugate(a), d);
}

// Rotation matrix of a unit quaternion.
template <class T>
COSPLAT_HD Mat3<T> RotationOf(const Quat<T>& q) {
  const T two(2);
  return {{T(1) - two * (q.y * q.y + q.z * q.z),
           two * (q.x * q.y - q.w * q.z),
           two * (q.x * q.z + q.w * q.y),
           two * (q.x * q.y + q.w * q.z),
           T(1) - two * (q.x * q.x + q.z * q.z),
           two * (q.y * q.z - q.w * q.x),
           two * (q.x * q.z - q.w * q.y),
           two * (q.y * q.z + q.w * q.x),
           T(1) - two * (q.x * q.x + q.y * q.y)}};
}
// d_q of RotationOf, with four independent components (chain with NormalizeVjp).
template <class T>
COSPLAT_HD Quat<T> RotationOfVjp(const Quat<T>& q, const Mat3<T>& d) {
  const T two(2), four(4);
  return {
      two * (q.x * (d(2, 1) - d(1, 2)) + q.y * (d(0, 2) - d(2, 0)) + q.z * (d(1, 0) - d(0, 1))),
      two * (q.y * (d(0, 1) + d(1, 0)) + q.z * (d(0, 2) + d(2, 0)) + q.w * (d(2, 1) - d(1, 2))) -
          four * q.x * (d(1, 1) + d(2, 2)),
      two * (q.x * (d(0, 1) + d(1, 0)) + q.z * (d(1, 2) + d(2, 1)) + q.w * (d(0, 2) - d(2, 0))) -
          four * q.y * (d(0, 0) + d(2, 2)),
      two * (q.x * (d(0, 2) + d(2, 0)) + q.y * (d(1, 2) + d(2, 1)) + q.w * (d(1, 0) - d(0, 1))) -
          four * q.z * (d(0, 0) + d(1, 1))};
}

COSPLAT_MATH_END
#endif

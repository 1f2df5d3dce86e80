// Vectors and 3x3 matrices of any scalar T: float, double, dual numbers, SIMD packs. Plain
// aggregates with value semantics; no Eigen, so that nvcc and Highway's targets can compile them.
#if defined(COSPLAT_SPLAT_MATH_VEC_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_VEC_H_
#undef COSPLAT_SPLAT_MATH_VEC_H_
#else
#define COSPLAT_SPLAT_MATH_VEC_H_
#endif

#include "splat/math/scalar.h"

COSPLAT_MATH_BEGIN

template <class T>
struct Vec2 {
  T x, y;
};

template <class T>
struct Vec3 {
  T x, y, z;
  COSPLAT_HD T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  COSPLAT_HD const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};

// The three numbers of a row: of an array, or where a pointer into [N, 3] points.
template <class Row>
COSPLAT_HD auto ToVec3(const Row& row) {
  return Vec3<std::remove_cvref_t<decltype(row[0])>>{row[0], row[1], row[2]};
}

template <class T>
struct Vec4 {
  T x, y, z, w;
};

template <class T>
COSPLAT_HD Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
COSPLAT_HD Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
COSPLAT_HD Vec3<T> operator-(const Vec3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
COSPLAT_HD Vec3<T> operator*(const Vec3<T>& a, T s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
COSPLAT_HD Vec3<T> operator*(T s, const Vec3<T>& a) {
  return a * s;
}
template <class T>
COSPLAT_HD Vec3<T>& operator+=(Vec3<T>& a, const Vec3<T>& b) {
  a = a + b;
  return a;
}
template <class T>
COSPLAT_HD Vec3<T>& operator-=(Vec3<T>& a, const Vec3<T>& b) {
  a = a - b;
  return a;
}
template <class T>
COSPLAT_HD T Dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
COSPLAT_HD Vec3<T> Cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// d(a x b): d_a = b x d, d_b = d x a.
template <class T>
COSPLAT_HD void CrossVjp(
    const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& d, Vec3<T>& d_a, Vec3<T>& d_b) {
  d_a += Cross(b, d);
  d_b += Cross(d, a);
}

// v / |v|, or the zero vector (with zero derivative) where |v|^2 <= 1e-30: a splat at the camera, a
// collapsed triangle.
template <class T>
COSPLAT_HD Vec3<T> Normalize(const Vec3<T>& v) {
  const T n2 = Dot(v, v);
  const auto ok = n2 > T(1e-30f);
  const T inv = Select(ok, T(1) / Sqrt(Select(ok, n2, T(1))), T(0));
  return v * inv;
}
template <class T>
COSPLAT_HD Vec3<T> NormalizeVjp(const Vec3<T>& v, const Vec3<T>& d) {
  const T n2 = Dot(v, v);
  const auto ok = n2 > T(1e-30f);
  const T inv = Select(ok, T(1) / Sqrt(Select(ok, n2, T(1))), T(0));
  const Vec3<T> u = v * inv;
  return (d - u * Dot(u, d)) * inv;
}

// |v|, with zero derivative at zero: the area of a collapsed triangle.
template <class T>
COSPLAT_HD T Length(const Vec3<T>& v) {
  const T n2 = Dot(v, v);
  const auto ok = n2 > T(1e-30f);
  return Select(ok, Sqrt(Select(ok, n2, T(1))), T(0));
}
template <class T>
COSPLAT_HD Vec3<T> LengthVjp(const Vec3<T>& v, const T& d) {
  return Normalize(v) * d;
}

// Row-major 3x3 matrix.
template <class T>
struct Mat3 {
  T m[9];
  COSPLAT_HD T& operator()(int r, int c) { return m[3 * r + c]; }
  COSPLAT_HD const T& operator()(int r, int c) const { return m[3 * r + c]; }
};

template <class T>
COSPLAT_HD Vec3<T> operator*(const Mat3<T>& a, const Vec3<T>& v) {
  return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z,
          a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
          a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}
// a^T v
template <class T>
COSPLAT_HD Vec3<T> TransposeTimes(const Mat3<T>& a, const Vec3<T>& v) {
  return {a.m[0] * v.x + a.m[3] * v.y + a.m[6] * v.z,
          a.m[1] * v.x + a.m[4] * v.y + a.m[7] * v.z,
          a.m[2] * v.x + a.m[5] * v.y + a.m[8] * v.z};
}
template <class T>
COSPLAT_HD Mat3<T> operator*(const Mat3<T>& a, const Mat3<T>& b) {
  Mat3<T> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return c;
}
template <class T>
COSPLAT_HD Mat3<T> Transpose(const Mat3<T>& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}
// a b^T
template <class T>
COSPLAT_HD Mat3<T> Outer(const Vec3<T>& a, const Vec3<T>& b) {
  return {{a.x * b.x,
           a.x * b.y,
           a.x * b.z,
           a.y * b.x,
           a.y * b.y,
           a.y * b.z,
           a.z * b.x,
           a.z * b.y,
           a.z * b.z}};
}

COSPLAT_MATH_END
#endif

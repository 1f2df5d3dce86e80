// The 3-vectors and row-major 3x3 matrices that FLAME's kinematics need, for any scalar T (float,
// double, dual numbers in tests). flame/ does not use splat/math's types.
// Meshes use Eigen inside .cpp files.
#pragma once

#include <array>
#include <cmath>

namespace cosplat::flame_math {

inline float Sqrt(float x) { return std::sqrt(x); }
inline double Sqrt(double x) { return std::sqrt(x); }
inline float Sin(float x) { return std::sin(x); }
inline double Sin(double x) { return std::sin(x); }
inline float Cos(float x) { return std::cos(x); }
inline double Cos(double x) { return std::cos(x); }

template <class T>
using Vector3 = std::array<T, 3>;
template <class T>
using Matrix3 = std::array<T, 9>;  // row-major

template <class T>
Matrix3<T> Identity() {
  return {T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)};
}

template <class T>
Vector3<T> Minus(const Vector3<T>& a, const Vector3<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

template <class T>
void AddTo(Vector3<T>& sum, const Vector3<T>& a) {
  for (int i = 0; i < 3; ++i) sum[i] += a[i];
}

template <class T>
void SubtractFrom(Vector3<T>& sum, const Vector3<T>& a) {
  for (int i = 0; i < 3; ++i) sum[i] -= a[i];
}

// a v
template <class T>
Vector3<T> Times(const Matrix3<T>& a, const Vector3<T>& v) {
  Vector3<T> r;
  for (int i = 0; i < 3; ++i) r[i] = a[3 * i] * v[0] + a[3 * i + 1] * v[1] + a[3 * i + 2] * v[2];
  return r;
}

// a^T v: the VJP of Times with respect to v.
template <class T>
Vector3<T> TransposeTimes(const Matrix3<T>& a, const Vector3<T>& v) {
  Vector3<T> r;
  for (int i = 0; i < 3; ++i) r[i] = a[i] * v[0] + a[3 + i] * v[1] + a[6 + i] * v[2];
  return r;
}

// sum += a b^T: the VJP of Times with respect to the matrix.
template <class T>
void AddOuter(Matrix3<T>& sum, const Vector3<T>& a, const Vector3<T>& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum[3 * i + j] += a[i] * b[j];
}

// a b
template <class T>
Matrix3<T> Times(const Matrix3<T>& a, const Matrix3<T>& b) {
  Matrix3<T> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  return c;
}

// Adds dL/da and dL/db of c = a b, given d_c.
template <class T>
void TimesVjp(const Matrix3<T>& a,
              const Matrix3<T>& b,
              const Matrix3<T>& d_c,
              Matrix3<T>& d_a,
              Matrix3<T>& d_b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        d_a[3 * i + k] += d_c[3 * i + j] * b[3 * k + j];
        d_b[3 * k + j] += d_c[3 * i + j] * a[3 * i + k];
      }
}

}  // namespace cosplat::flame_math

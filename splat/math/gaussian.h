// A Gaussian's 3D covariance from its rotation and scale.
// Source: Kerbl et al. 2023, eq. 6: Sigma = R S S^T R^T.
#if defined(COSPLAT_SPLAT_MATH_GAUSSIAN_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_GAUSSIAN_H_
#undef COSPLAT_SPLAT_MATH_GAUSSIAN_H_
#else
#define COSPLAT_SPLAT_MATH_GAUSSIAN_H_
#endif

#include "splat/math/quat.h"

COSPLAT_MATH_BEGIN

// Symmetric 3x3 matrix of six numbers. As a gradient, an off-diagonal entry is the derivative with
// respect to that one number, which appears twice in the matrix.
template <class T>
struct Sym3 {
  T xx, xy, xz, yy, yz, zz;
};

// a v of the symmetric matrix `a` and a vector `v`.
template <class T>
COSPLAT_HD Vec3<T> operator*(const Sym3<T>& a, const Vec3<T>& v) {
  return {a.xx * v.x + a.xy * v.y + a.xz * v.z,
          a.xy * v.x + a.yy * v.y + a.yz * v.z,
          a.xz * v.x + a.yz * v.y + a.zz * v.z};
}

// R S: the columns of R times the standard deviations.
template <class T>
COSPLAT_HD Mat3<T> ScaleColumns(const Mat3<T>& r, const Vec3<T>& s) {
  return {{r.m[0] * s.x,
           r.m[1] * s.y,
           r.m[2] * s.z,
           r.m[3] * s.x,
           r.m[4] * s.y,
           r.m[5] * s.z,
           r.m[6] * s.x,
           r.m[7] * s.y,
           r.m[8] * s.z}};
}

// rotation: wxyz of any norm; scale: standard deviations (> 0), world units.
template <class T>
COSPLAT_HD Sym3<T> Covariance(const Quat<T>& rotation, const Vec3<T>& scale) {
  const Mat3<T> m = ScaleColumns(RotationOf(Normalize(rotation)), scale);
  return {m(0, 0) * m(0, 0) + m(0, 1) * m(0, 1) + m(0, 2) * m(0, 2),
          m(0, 0) * m(1, 0) + m(0, 1) * m(1, 1) + m(0, 2) * m(1, 2),
          m(0, 0) * m(2, 0) + m(0, 1) * m(2, 1) + m(0, 2) * m(2, 2),
          m(1, 0) * m(1, 0) + m(1, 1) * m(1, 1) + m(1, 2) * m(1, 2),
          m(1, 0) * m(2, 0) + m(1, 1) * m(2, 1) + m(1, 2) * m(2, 2),
          m(2, 0) * m(2, 0) + m(2, 1) * m(2, 1) + m(2, 2) * m(2, 2)};
}

// Writes d_rotation and d_scale. With M = R S and G the symmetric gradient, d_M = 2 G M.
template <class T>
COSPLAT_HD void CovarianceVjp(const Quat<T>& rotation,
                              const Vec3<T>& scale,
                              const Sym3<T>& d,
                              Quat<T>& d_rotation,
                              Vec3<T>& d_scale) {
  const Quat<T> q = Normalize(rotation);
  const Mat3<T> r = RotationOf(q);
  const Mat3<T> m = ScaleColumns(r, scale);
  const T two(2);
  const Mat3<T> g2 = {{two * d.xx, d.xy, d.xz, d.xy, two * d.yy, d.yz, d.xz, d.yz, two * d.zz}};
  const Mat3<T> d_m = g2 * m;
  d_scale = {d_m(0, 0) * r(0, 0) + d_m(1, 0) * r(1, 0) + d_m(2, 0) * r(2, 0),
             d_m(0, 1) * r(0, 1) + d_m(1, 1) * r(1, 1) + d_m(2, 1) * r(2, 1),
             d_m(0, 2) * r(0, 2) + d_m(1, 2) * r(1, 2) + d_m(2, 2) * r(2, 2)};
  d_rotation = NormalizeVjp(rotation, RotationOfVjp(q, ScaleColumns(d_m, scale)));
}

// The 3D smoothing filter: a Gaussian after convolution with an isotropic one of `variance`, world
// units^2. It grows, and keeps only a share of its opacity, so that its integral stays what it was:
// sqrt(det(Sigma) / det(Sigma + variance I)). Source: Yu et al. 2024 (Mip-Splatting).
template <class T>
struct SmoothedScale {
  Vec3<T> scale;  // standard deviations
  T share;
};
template <class T>
COSPLAT_HD SmoothedScale<T> SmoothScale(const Vec3<T>& s, T variance) {
  const Vec3<T> grown{
      Sqrt(s.x * s.x + variance), Sqrt(s.y * s.y + variance), Sqrt(s.z * s.z + variance)};
  return {grown, (s.x / grown.x) * (s.y / grown.y) * (s.z / grown.z)};
}
// Given the result, returns the gradient with respect to log(s), which stays finite as s shrinks.
template <class T>
COSPLAT_HD Vec3<T> SmoothScaleVjp(const Vec3<T>& s,
                                  T variance,
                                  const SmoothedScale<T>& smoothed,
                                  const Vec3<T>& d_scale,
                                  T d_share) {
  const Vec3<T>& g = smoothed.scale;
  const T d = d_share * smoothed.share * variance;
  return {d_scale.x * s.x * s.x / g.x + d / (g.x * g.x),
          d_scale.y * s.y * s.y / g.y + d / (g.y * g.y),
          d_scale.z * s.z * s.z / g.z + d / (g.z * g.z)};
}

COSPLAT_MATH_END
#endif

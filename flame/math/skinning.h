// Linear blend skinning of one vertex, and its derivative (Li et al. 2017, eq. 2).
#pragma once

#include "flame/math/kinematics.h"

namespace cosplat::flame_math {

// sum_j w_j (R_j p + t_j), on plain arrays so that devices can run it: rotation [N, 9] row-major,
// translation [N, 3], weights [N], summing to 1, p and posed [3].
template <int N, class T>
COSPLAT_HD void SkinPoint(
    const T* rotation, const T* translation, const T* weights, const T* p, T* posed) {
  T r[9] = {}, t[3] = {};
  for (int j = 0; j < N; ++j) {
    for (int i = 0; i < 9; ++i) r[i] += weights[j] * rotation[9 * j + i];
    for (int i = 0; i < 3; ++i) t[i] += weights[j] * translation[3 * j + i];
  }
  const T x = p[0], y = p[1], z = p[2];  // `posed` may alias `p`
  for (int i = 0; i < 3; ++i)
    posed[i] = t[i] + (r[3 * i] * x + r[3 * i + 1] * y + r[3 * i + 2] * z);
}
template <class T, size_t N>
Vec3<T> SkinPoint(const JointTransforms<T, N>& joints, const T* weights, const Vec3<T>& p) {
  Vec3<T> posed;
  SkinPoint<int(N)>(joints.rotation[0].m, &joints.translation[0].x, weights, &p.x, &posed.x);
  return posed;
}

// Adds to d_joints; returns d_p.
template <class T, size_t N>
Vec3<T> SkinPointVjp(const JointTransforms<T, N>& joints,
                     const T* weights,
                     const Vec3<T>& p,
                     const Vec3<T>& d,
                     JointTransforms<T, N>& d_joints) {
  const Mat3<T> outer = Outer(d, p);
  Mat3<T> rotation{};
  for (size_t j = 0; j < N; ++j) {
    for (int i = 0; i < 9; ++i) {
      rotation.m[i] += weights[j] * joints.rotation[j].m[i];
      d_joints.rotation[j].m[i] += weights[j] * outer.m[i];
    }
    d_joints.translation[j] += weights[j] * d;
  }
  return TransposeTimes(rotation, d);
}

// The contribution of blend shapes to one vertex coordinate (Li et al. 2017, eq. 3 and 4):
// coefficients times the directions' values there. The CPU loops over coordinates
// (flame/directions.h), a device over directions (flame/kernels/pose.h); both add in this order.

// Four directions at once, so that the sum is loaded and stored less often.
template <class T>
COSPLAT_HD T AddFourDirections(T sum, const T* coefficients, T d0, T d1, T d2, T d3) {
  const T* const c = coefficients;
  return sum + ((c[0] * d0 + c[1] * d1) + (c[2] * d2 + c[3] * d3));
}
// The remaining directions, one at a time.
template <class T>
COSPLAT_HD T AddDirection(T sum, T coefficient, T d) {
  return sum + coefficient * d;
}

}  // namespace cosplat::flame_math

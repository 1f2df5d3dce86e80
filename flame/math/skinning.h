// Linear blend skinning of one vertex, and its derivative (Li et al. 2017, eq. 2).
#pragma once

#include "flame/math/kinematics.h"

namespace cosplat::flame_math {

// sum_j w_j (R_j p + t_j). weights: [N], summing to 1.
template <class T, size_t N>
Vector3<T> SkinPoint(const JointTransforms<T, N>& joints, const T* weights, const Vector3<T>& p) {
  Matrix3<T> rotation{};
  Vector3<T> posed{};
  for (size_t j = 0; j < N; ++j) {
    for (int i = 0; i < 9; ++i) rotation[i] += weights[j] * joints.rotation[j][i];
    for (int i = 0; i < 3; ++i) posed[i] += weights[j] * joints.translation[j][i];
  }
  AddTo(posed, Times(rotation, p));
  return posed;
}

// Adds to d_joints; returns d_p.
template <class T, size_t N>
Vector3<T> SkinPointVjp(const JointTransforms<T, N>& joints,
                        const T* weights,
                        const Vector3<T>& p,
                        const Vector3<T>& d,
                        JointTransforms<T, N>& d_joints) {
  Matrix3<T> outer{}, rotation{};
  AddOuter(outer, d, p);
  for (size_t j = 0; j < N; ++j) {
    for (int i = 0; i < 9; ++i) {
      rotation[i] += weights[j] * joints.rotation[j][i];
      d_joints.rotation[j][i] += weights[j] * outer[i];
    }
    for (int i = 0; i < 3; ++i) d_joints.translation[j][i] += weights[j] * d[i];
  }
  return TransposeTimes(rotation, d);
}

}  // namespace cosplat::flame_math

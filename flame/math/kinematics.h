// The kinematic tree: local joint rotations and rest positions -> the rigid transforms that
// skinning blends, G_j * T(-J_j) in Li et al. 2017, eq. 2-3. The root rotates about its own joint.
#pragma once

#include <cstddef>

#include "flame/math/linear.h"

namespace cosplat::flame_math {

// posed = rotation[j] * rest + translation[j]
template <class T, size_t N>
struct JointTransforms {
  std::array<Matrix3<T>, N> rotation;
  std::array<Vector3<T>, N> translation;
};

// local[j]: rotation relative to the parent; joints[j]: rest position; parents[0] = -1 and
// parents[j] < j.
template <class T, size_t N>
JointTransforms<T, N> PoseJoints(const std::array<Matrix3<T>, N>& local,
                                 const std::array<Vector3<T>, N>& joints,
                                 const std::array<int, N>& parents) {
  JointTransforms<T, N> out;
  out.rotation[0] = local[0];
  out.translation[0] = Minus(joints[0], Times(local[0], joints[0]));
  for (size_t j = 1; j < N; ++j) {
    const int p = parents[j];
    // The joint itself moves with its parent; everything else rotates about it.
    Vector3<T> posed_joint = Times(out.rotation[p], joints[j]);
    AddTo(posed_joint, out.translation[p]);
    out.rotation[j] = Times(out.rotation[p], local[j]);
    out.translation[j] = Minus(posed_joint, Times(out.rotation[j], joints[j]));
  }
  return out;
}

// Adds to d_local and d_joints, given the transforms `out` = PoseJoints(...) and d_out (consumed).
template <class T, size_t N>
void PoseJointsVjp(const std::array<Matrix3<T>, N>& local,
                   const std::array<Vector3<T>, N>& joints,
                   const std::array<int, N>& parents,
                   const JointTransforms<T, N>& out,
                   JointTransforms<T, N> d_out,
                   std::array<Matrix3<T>, N>& d_local,
                   std::array<Vector3<T>, N>& d_joints) {
  for (int j = int(N) - 1; j >= 0; --j) {
    const Vector3<T> d_t = d_out.translation[j];
    const Vector3<T> minus_d_t = {-d_t[0], -d_t[1], -d_t[2]};
    AddOuter(d_out.rotation[j], minus_d_t, joints[j]);
    SubtractFrom(d_joints[j], TransposeTimes(out.rotation[j], d_t));
    if (j == 0) {
      AddTo(d_joints[0], d_t);
      for (int i = 0; i < 9; ++i) d_local[0][i] += d_out.rotation[0][i];
      break;
    }
    const int p = parents[j];
    TimesVjp(out.rotation[p], local[j], d_out.rotation[j], d_out.rotation[p], d_local[j]);
    AddOuter(d_out.rotation[p], d_t, joints[j]);
    AddTo(d_joints[j], TransposeTimes(out.rotation[p], d_t));
    AddTo(d_out.translation[p], d_t);
  }
}

}  // namespace cosplat::flame_math

// The kinematic tree: local joint rotations and rest positions -> the rigid transforms that
// skinning blends, G_j * T(-J_j) in Li et al. 2017, eq. 2-3. The root rotates about its own joint.
#pragma once

#include <array>
#include <cstddef>

#include "splat/math/vec.h"

namespace cosplat::flame_math {

using math::Mat3;
using math::Vec3;

// sum += a b^T: the VJP of a matrix's product with a vector, with respect to the matrix.
template <class T>
void AddOuter(Mat3<T>& sum, const Vec3<T>& a, const Vec3<T>& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum(i, j) += a[i] * b[j];
}

// Adds dL/da and dL/db of c = a b, given d_c.
template <class T>
void ProductVjp(
    const Mat3<T>& a, const Mat3<T>& b, const Mat3<T>& d_c, Mat3<T>& d_a, Mat3<T>& d_b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        d_a(i, k) += d_c(i, j) * b(k, j);
        d_b(k, j) += d_c(i, j) * a(i, k);
      }
}

// posed = rotation[j] * rest + translation[j]
template <class T, size_t N>
struct JointTransforms {
  std::array<Mat3<T>, N> rotation;
  std::array<Vec3<T>, N> translation;
};

// local[j]: rotation relative to the parent; joints[j]: rest position; parents[0] = -1 and
// parents[j] < j.
template <class T, size_t N>
JointTransforms<T, N> PoseJoints(const std::array<Mat3<T>, N>& local,
                                 const std::array<Vec3<T>, N>& joints,
                                 const std::array<int, N>& parents) {
  JointTransforms<T, N> out;
  out.rotation[0] = local[0];
  out.translation[0] = joints[0] - local[0] * joints[0];
  for (size_t j = 1; j < N; ++j) {
    const int p = parents[j];
    // The joint itself moves with its parent; everything else rotates about it.
    const Vec3<T> posed_joint = out.rotation[p] * joints[j] + out.translation[p];
    out.rotation[j] = out.rotation[p] * local[j];
    out.translation[j] = posed_joint - out.rotation[j] * joints[j];
  }
  return out;
}

// Adds to d_local and d_joints, given the transforms `out` = PoseJoints(...) and d_out (consumed).
template <class T, size_t N>
void PoseJointsVjp(const std::array<Mat3<T>, N>& local,
                   const std::array<Vec3<T>, N>& joints,
                   const std::array<int, N>& parents,
                   const JointTransforms<T, N>& out,
                   JointTransforms<T, N> d_out,
                   std::array<Mat3<T>, N>& d_local,
                   std::array<Vec3<T>, N>& d_joints) {
  for (int j = int(N) - 1; j >= 0; --j) {
    const Vec3<T> d_t = d_out.translation[j];
    AddOuter(d_out.rotation[j], -d_t, joints[j]);
    d_joints[j] -= TransposeTimes(out.rotation[j], d_t);
    if (j == 0) {
      d_joints[0] += d_t;
      for (int i = 0; i < 9; ++i) d_local[0].m[i] += d_out.rotation[0].m[i];
      break;
    }
    const int p = parents[j];
    ProductVjp(out.rotation[p], local[j], d_out.rotation[j], d_out.rotation[p], d_local[j]);
    AddOuter(d_out.rotation[p], d_t, joints[j]);
    d_joints[j] += TransposeTimes(out.rotation[p], d_t);
    d_out.translation[p] += d_t;
  }
}

}  // namespace cosplat::flame_math

// Kernels that pose individual vertices after the joints, which a device runs with one thread each
// (avatar/surface/cuda/kernels.cu). FlamePoser applies the same formulas to strips of vertices.
//
// PosingArrays, FlameRig -> BlendShapesKernel -> SkinKernel -> posed vertices.
#pragma once

#include "flame/math/skinning.h"
#include "flame/posing.h"

namespace cosplat::flame_math {

// sum plus the terms' coefficients times their directions, each of `rows` numbers, at `row`.
template <class T>
COSPLAT_HD T AddDirections(T sum,
                           const T* directions,
                           size_t rows,
                           const DirectionTerm<T>* terms,
                           size_t count,
                           size_t row) {
  const auto at = [&](size_t t) { return directions[size_t(terms[t].direction) * rows + row]; };
  size_t t = 0;
  for (; t + 4 <= count; t += 4) {
    const T c[4] = {terms[t].coefficient,
                    terms[t + 1].coefficient,
                    terms[t + 2].coefficient,
                    terms[t + 3].coefficient};
    sum = AddFourDirections(sum, c, at(t), at(t + 1), at(t + 2), at(t + 3));
  }
  for (; t < count; ++t) sum = AddDirection(sum, terms[t].coefficient, at(t));
  return sum;
}

// For each of the 3 V vertex coordinates.
template <class T>
struct BlendShapesKernel {
  PosingArrays<T> arrays;
  const DirectionTerm<T>* terms;  // as in FlameRig
  size_t expression_terms, pose_terms;
  T* unskinned;  // [V, 3]

  COSPLAT_HD void operator()(size_t i) const {
    const size_t rows = 3 * arrays.vertex_count;
    // Two sums, like those in FlamePoser's cache.
    const T expressed = AddDirections(
        arrays.shaped[i], arrays.expression_directions, rows, terms, expression_terms, i);
    const T corrections =
        AddDirections(T(0), arrays.pose_directions, rows, terms + expression_terms, pose_terms, i);
    unskinned[i] = expressed + corrections;
  }
};

// For each vertex.
template <class T>
struct SkinKernel {
  T rotation[9 * kFlameJoints], joint_translation[3 * kFlameJoints], translation[3];
  const T* weights;    // [V, kFlameJoints]
  const T* unskinned;  // [V, 3]
  T* vertices;         // [V, 3] metres

  SkinKernel(const FlameRig<T>& rig, const T* weights, const T* unskinned, T* vertices)
      : weights(weights), unskinned(unskinned), vertices(vertices) {
    for (size_t j = 0; j < kFlameJoints; ++j) {
      for (size_t i = 0; i < 9; ++i) rotation[9 * j + i] = rig.transforms.rotation[j].m[i];
      for (size_t i = 0; i < 3; ++i)
        joint_translation[3 * j + i] = rig.transforms.translation[j][i];
    }
    for (size_t i = 0; i < 3; ++i) translation[i] = rig.translation[i];
  }

  COSPLAT_HD void operator()(size_t v) const {
    T posed[3];
    SkinPoint<kFlameJoints>(
        rotation, joint_translation, weights + kFlameJoints * v, unskinned + 3 * v, posed);
    for (size_t i = 0; i < 3; ++i) vertices[3 * v + i] = posed[i] + translation[i];
  }
};

}  // namespace cosplat::flame_math

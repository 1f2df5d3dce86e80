// SplattingAvatar's formulas as its first code release computes them, including the faults that
// avatar/math/embed.h avoids. Described in docs/stability.md.
//
// Only the preset that reproduces the release and the measurements that compare it with this
// project may use them (apps/study/avatar_stability/). Written from the mathematics, after Shao et
// al. 2024:
//
//   log s_world = alpha * log s        alpha = (A + 1e-4) / (A0 + 1e-4), s and A in the units of a
//                                      FLAME mesh enlarged four times. The paper scales s itself;
//                                      this enlarges s < 1 where the triangle shrinks.
//   q = norm(sum w_i q_i)              over a vertex's faces by area, then a triangle's corners by
//                                      barycentrics; q and -q, the same rotation, cancel.
//   b' = b reflected                   as if the two triangles at an edge formed a parallelogram;
//                                      where they do not, a path bends at the edge.
#if defined(COSPLAT_AVATAR_MATH_RELEASED_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_RELEASED_H_
#undef COSPLAT_AVATAR_MATH_RELEASED_H_
#else
#define COSPLAT_AVATAR_MATH_RELEASED_H_
#endif

#include "splat/math/quat.h"

COSPLAT_MATH_BEGIN

// Added to both areas of the ratio, in the release's squared units.
constexpr float kReleasedAreaFloor = 1e-4f;

// alpha. Areas of the Gaussian's face are in square metres; `unit` is metres per unit of a mesh
// enlarged four times (MeshUnit, avatar/surface/surface.h).
template <class T>
COSPLAT_HD T ReleasedAreaRatio(const T& area, const T& canonical, const T& unit) {
  const T floor = T(kReleasedAreaFloor) * unit * unit;
  return (area + floor) / (canonical + floor);
}

// log(metres) on the canonical mesh -> log(metres) in the world.
template <class T>
COSPLAT_HD Vec3<T> ReleasedScale(const Vec3<T>& scale_log,
                                 const T& area,
                                 const T& canonical,
                                 const T& unit) {
  const T alpha = ReleasedAreaRatio(area, canonical, unit), shift = Log(unit);
  return {alpha * (scale_log.x - shift) + shift,
          alpha * (scale_log.y - shift) + shift,
          alpha * (scale_log.z - shift) + shift};
}

// Sum of w_i q_i without aligning signs: may vanish even where all q_i are the same rotation.
template <class T>
COSPLAT_HD Quat<T> UnalignedSum(const Quat<T>* q, const T* w, int count) {
  Quat<T> sum{T(0), T(0), T(0), T(0)};
  for (int i = 0; i < count; ++i) sum = sum + q[i] * w[i];
  return sum;
}
// The normalised sum. A sum that is too short for Normalize gives the identity.
template <class T>
COSPLAT_HD Quat<T> UnalignedBlend(const Quat<T>* q, const T* w, int count) {
  return Normalize(UnalignedSum(q, w, count));
}

// Converts, in place, the weights of a point on one triangle to those on the triangle across the
// edge from a to b, as if the corner there were at a + b - opposite. `opposite` is negative beyond
// the edge and becomes the weight of the other corner. Linear: steps are converted in the same way.
template <class T>
COSPLAT_HD void ParallelogramCrossing(T& a, T& b, T& opposite) {
  a = a + opposite;
  b = b + opposite;
  opposite = -opposite;
}

COSPLAT_MATH_END
#endif

// The embedding of one Gaussian on a triangle as SplattingAvatar's code release computes it, and
// its derivative: the counterpart of avatar/math/embed.h.
//
// posed vertices with rotations that were summed unaligned, the face's areas and a Gaussian's
// (delta_u, delta_v, d), local rotation and scale -> the Gaussian in the posed frame's world
// (avatar/surface/binding.h).
//
//   b = (u, v, 1 - u - v)                du and dv are not used
//   mu = sum b_i v_i + d * norm(sum b_i N_i)
//   rotation = q (x) q_local             q = norm(sum b_i q_i), signs not aligned
//   log s = alpha * log s_local          alpha and the unit of s: avatar/math/released.h
#if defined(COSPLAT_AVATAR_MATH_RELEASED_EMBED_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_RELEASED_EMBED_H_
#undef COSPLAT_AVATAR_MATH_RELEASED_EMBED_H_
#else
#define COSPLAT_AVATAR_MATH_RELEASED_EMBED_H_
#endif

#include "avatar/math/embed.h"
#include "avatar/math/released.h"

COSPLAT_MATH_BEGIN

// Square metres, and metres per unit of the enlarged mesh (avatar/math/released.h).
template <class T>
struct ReleasedFace {
  T area, canonical_area, unit;
};

template <class T>
COSPLAT_HD Three<T> ReleasedWeights(const EmbeddedGaussian<T>& g) {
  return {{g.barycentric[0], g.barycentric[1], T(1) - g.barycentric[0] - g.barycentric[1]}};
}
template <class T>
COSPLAT_HD Quat<T> ReleasedRotation(const Three<SurfaceVertex<T>>& v, const Three<T>& b) {
  const Quat<T> rotations[3] = {v[0].rotation, v[1].rotation, v[2].rotation};
  return UnalignedBlend(rotations, b.c, 3);
}

template <class T>
COSPLAT_HD PosedGaussian<T> ReleasedEmbed(const Three<SurfaceVertex<T>>& v,
                                          const ReleasedFace<T>& face,
                                          const EmbeddedGaussian<T>& g) {
  const Three<T> b = ReleasedWeights(g);
  const Vec3<T> n = Normalize(Blend(v[0].normal, v[1].normal, v[2].normal, b));
  const Quat<T> q = ReleasedRotation(v, b);
  return {Blend(v[0].position, v[1].position, v[2].position, b) + n * g.offset.z,
          Multiply(q, g.rotation),
          ReleasedScale(g.scale_log, face.area, face.canonical_area, face.unit),
          q};
}
// Overwrites d_g. The mesh is held fixed, so q and d.frame contribute nothing.
template <class T>
COSPLAT_HD void ReleasedEmbedVjp(const Three<SurfaceVertex<T>>& v,
                                 const ReleasedFace<T>& face,
                                 const EmbeddedGaussian<T>& g,
                                 const PosedGaussian<T>& d,
                                 EmbeddedGaussian<T>& d_g) {
  const T zero(0);
  const Three<T> b = ReleasedWeights(g);
  const Vec3<T> n = Normalize(Blend(v[0].normal, v[1].normal, v[2].normal, b));
  d_g.barycentric[0] = d_g.barycentric[1] = zero;
  d_g.offset = {zero, zero, Dot(n, d.position)};
  d_g.rotation = Multiply(Conjugate(ReleasedRotation(v, b)), d.rotation);
  d_g.scale_log = d.scale_log * ReleasedAreaRatio(face.area, face.canonical_area, face.unit);
}

COSPLAT_MATH_END
#endif

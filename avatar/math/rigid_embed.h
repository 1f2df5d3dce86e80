// The embedding of one Gaussian that turns and grows with its face, as GaussianAvatars' do: the
// counterpart of avatar/math/embed.h.
//
// posed corners of a face and a Gaussian in the face's frame and unit -> the Gaussian in the posed
// frame's world (avatar/surface/binding.h).
//
//   T = (v0 + v1 + v2) / 3             R = (e, n, e x n)     e along v1 - v0, n the normal
//   s = (|v1 - v0| + h) / 2            h: height of v2 above the line through v0 and v1
//   mu = T + s R mu_local
//   rotation = R (x) q_local           log s_world = log s_local + log s
//
// Source: Qian et al. 2024, "3D Gaussian rigging"; the axes of R and the two lengths in s are those
// of its released code. Avatars are played by this rule, not trained, so that it has no derivative
// here.
#if defined(COSPLAT_AVATAR_MATH_RIGID_EMBED_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_RIGID_EMBED_H_
#undef COSPLAT_AVATAR_MATH_RIGID_EMBED_H_
#else
#define COSPLAT_AVATAR_MATH_RIGID_EMBED_H_
#endif

#include "avatar/math/frame.h"

COSPLAT_MATH_BEGIN

// Metres. Below it a face counts as collapsed, so that the logarithm stays finite.
constexpr float kMinFaceUnit = 1e-12f;

// A Gaussian in its face's frame: lengths in units of s.
template <class T>
struct RigidGaussian {
  Vec3<T> position;
  Quat<T> rotation;
  Vec3<T> scale_log;
};

// T, R and s. A collapsed face has zero columns in R.
template <class T>
struct RigidFace {
  Vec3<T> center;
  Mat3<T> frame;
  T unit;
};

template <class T>
COSPLAT_HD RigidFace<T> RigidFaceOf(const Vec3<T>& v0, const Vec3<T>& v1, const Vec3<T>& v2) {
  const Vec3<T> edge = v1 - v0, e = Normalize(edge), c = Cross(e, v2 - v0), n = Normalize(c);
  return {(v0 + v1 + v2) * T(1.0f / 3),
          MatrixOfColumns(e, n, Cross(e, n)),
          (Length(edge) + Length(c)) * T(0.5f)};
}

// In the world: position, rotation and scale.
template <class T>
COSPLAT_HD RigidGaussian<T> RigidEmbed(const RigidFace<T>& face, const RigidGaussian<T>& g) {
  const T shift = Log(Max(face.unit, T(kMinFaceUnit)));
  return {face.center + face.frame * g.position * face.unit,
          Multiply(QuatOfRotation(face.frame), g.rotation),
          g.scale_log + Vec3<T>{shift, shift, shift}};
}

COSPLAT_MATH_END
#endif

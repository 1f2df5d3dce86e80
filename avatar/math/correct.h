// What a frame's expression changes about a Gaussian beyond what its mesh carries.
//
// A Gaussian has K bases of 14 numbers each (kCorrection of splat/gaussians.h), and a frame K
// weights (avatar/model/corrections.h):
//
//   c          = sum_k weight_k basis_k, each number in its unit below
//   rotation   = q_local + c, scale_log = s_local + c, before Embed (avatar/math/embed.h)
//   mean       = mu + R(q) c, q the rotation from canonical to posed at the Gaussian
//   opacity_logit, color_dc: the Gaussian's own + c
//
// Reduced blendshapes: Li et al. 2025 (RGBAvatar), Ma et al. 2024 (3D Gaussian Blendshapes). Here
// the offset is a vector in the canonical frame instead of one along the triangle, so that it stays
// valid when its Gaussian walks to another triangle.
#if defined(COSPLAT_AVATAR_MATH_CORRECT_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_CORRECT_H_
#undef COSPLAT_AVATAR_MATH_CORRECT_H_
#else
#define COSPLAT_AVATAR_MATH_CORRECT_H_
#endif

#include "avatar/math/embed.h"

COSPLAT_MATH_BEGIN

// Numbers of a basis: offset 3, rotation 4, scale 3, opacity 1, colour 3.
constexpr int kCorrectionWidth = 14;

// Units of the bases' numbers, in proportion to the learning rates of the attributes that they
// change, so that one learning rate suits all of them.
constexpr float kCorrectionOffsetUnit = 0.02f;  // metres
constexpr float kCorrectionRotationUnit = 1;
constexpr float kCorrectionScaleUnit = 5;
constexpr float kCorrectionOpacityUnit = 20;
constexpr float kCorrectionColorUnit = 2.5f;

// A sum of weighted bases in their units, or its derivative.
template <class T>
struct Correction {
  Vec3<T> offset;  // canonical frame
  Quat<T> rotation;
  Vec3<T> scale_log;
  T opacity_logit;
  Vec3<T> color_dc;
};

template <class T>
COSPLAT_HD Correction<T> CorrectionOf(const T (&c)[kCorrectionWidth]) {
  const T offset(kCorrectionOffsetUnit), rotation(kCorrectionRotationUnit);
  const T scale(kCorrectionScaleUnit), color(kCorrectionColorUnit);
  return {Vec3<T>{c[0], c[1], c[2]} * offset,
          Quat<T>{c[3], c[4], c[5], c[6]} * rotation,
          Vec3<T>{c[7], c[8], c[9]} * scale,
          c[10] * T(kCorrectionOpacityUnit),
          Vec3<T>{c[11], c[12], c[13]} * color};
}
template <class T>
COSPLAT_HD void CorrectionOfVjp(const Correction<T>& d, T (&d_c)[kCorrectionWidth]) {
  const T in_units[kCorrectionWidth] = {d.offset.x * T(kCorrectionOffsetUnit),
                                        d.offset.y * T(kCorrectionOffsetUnit),
                                        d.offset.z * T(kCorrectionOffsetUnit),
                                        d.rotation.w * T(kCorrectionRotationUnit),
                                        d.rotation.x * T(kCorrectionRotationUnit),
                                        d.rotation.y * T(kCorrectionRotationUnit),
                                        d.rotation.z * T(kCorrectionRotationUnit),
                                        d.scale_log.x * T(kCorrectionScaleUnit),
                                        d.scale_log.y * T(kCorrectionScaleUnit),
                                        d.scale_log.z * T(kCorrectionScaleUnit),
                                        d.opacity_logit * T(kCorrectionOpacityUnit),
                                        d.color_dc.x * T(kCorrectionColorUnit),
                                        d.color_dc.y * T(kCorrectionColorUnit),
                                        d.color_dc.z * T(kCorrectionColorUnit)};
  for (int i = 0; i < kCorrectionWidth; ++i) d_c[i] = in_units[i];
}

// Embed of a corrected Gaussian.
template <class T>
COSPLAT_HD PosedGaussian<T> EmbedCorrected(const Three<SurfaceVertex<T>>& v,
                                           const Three<T>& canonical_area,
                                           EmbeddedGaussian<T> g,
                                           const Correction<T>& c) {
  g.rotation = g.rotation + c.rotation;
  g.scale_log += c.scale_log;
  PosedGaussian<T> posed = Embed(v, canonical_area, g);
  posed.position += RotationOf(posed.frame) * c.offset;
  return posed;
}
// Derivative of EmbedCorrected: as EmbedVjp, and overwrites offset, rotation and scale of d_c.
template <class T>
COSPLAT_HD void EmbedCorrectedVjp(const Three<SurfaceVertex<T>>& v,
                                  const Three<T>& canonical_area,
                                  EmbeddedGaussian<T> g,
                                  const Correction<T>& c,
                                  PosedGaussian<T> d,
                                  EmbeddedGaussian<T>& d_g,
                                  Correction<T>& d_c,
                                  Three<SurfaceVertex<T>>* d_v) {
  g.rotation = g.rotation + c.rotation;
  g.scale_log += c.scale_log;
  const Quat<T> q = BlendRotations({{v[0].rotation, v[1].rotation, v[2].rotation}},
                                   PositivePart(BarycentricOf(g)));
  d_c.offset = TransposeTimes(RotationOf(q), d.position);
  d.frame = d.frame + RotationOfVjp(q, Outer(d.position, c.offset));
  EmbedVjp(v, canonical_area, g, d, d_g, d_v);
  d_c.rotation = d_g.rotation;
  d_c.scale_log = d_g.scale_log;
}

COSPLAT_MATH_END
#endif

// The embedding of one Gaussian on a triangle, and its derivative.
//
// posed vertices' positions, normals, rotations, areas (avatar/surface/binding.h) and a Gaussian's
// (delta_u, delta_v, d), local rotation and scale -> the Gaussian in the posed frame's world.
//
//   b  = (u + du, v + dv, 1 - u - v - du - dv)          w  = positive part of b, sum 1
//   mu = sum b_i v_i + d * norm(sum b_i N_i)            q  = norm(sum +-w_i q_i)
//   rotation = q (x) q_local                            log s = log s_local + log(A / A0) / 2
//
// Embedding after SplattingAvatar (Shao et al. 2024), equations 1 to 4. This project differs in
// that quaternions are aligned to one hemisphere before they are blended, and that the scale
// follows the square root of the area ratio, clamped, with areas averaged at the vertices so that
// nothing jumps at an edge. Quantities that must not be extrapolated beyond the triangle (rotation,
// area) are evaluated at w, the positive part of b.
#if defined(COSPLAT_AVATAR_MATH_EMBED_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_EMBED_H_
#undef COSPLAT_AVATAR_MATH_EMBED_H_
#else
#define COSPLAT_AVATAR_MATH_EMBED_H_
#endif

#include "avatar/math/frame.h"

COSPLAT_MATH_BEGIN

// Bounds of A / A0: a Gaussian shrinks or grows at most four times. The released SplattingAvatar
// has no bound, and its scales blow up where triangles shrink (avatar/math/released.h).
constexpr float kMinAreaRatio = 1.0f / 16;
constexpr float kMaxAreaRatio = 16.0f;

// One value per corner of a triangle.
template <class T>
struct Three {
  T c[3];
  COSPLAT_HD T& operator[](int i) { return c[i]; }
  COSPLAT_HD const T& operator[](int i) const { return c[i]; }
};

// A vertex of the posed surface.
template <class T>
struct SurfaceVertex {
  Vec3<T> position;
  Vec3<T> normal;    // unit, area-weighted; zero where the faces around it cancel
  Quat<T> rotation;  // unit, canonical to posed
  T area;            // mean area of the faces around it
};

// A Gaussian on its triangle. du, dv are added to its barycentrics.
template <class T>
struct EmbeddedGaussian {
  T barycentric[2];  // (u, v)
  Vec3<T> offset;    // (du, dv, d)
  Quat<T> rotation;
  Vec3<T> scale_log;
};

template <class T>
struct PosedGaussian {
  Vec3<T> position;
  Quat<T> rotation;
  Vec3<T> scale_log;
  Quat<T> frame;  // q, unit
};

template <class T>
COSPLAT_HD Three<T> BarycentricOf(const EmbeddedGaussian<T>& g) {
  const T u = g.barycentric[0] + g.offset.x, v = g.barycentric[1] + g.offset.y;
  return {{u, v, T(1) - u - v}};
}

// Sets negative weights to zero and renormalises the sum to 1. The identity inside the triangle.
template <class T>
COSPLAT_HD Three<T> PositivePart(const Three<T>& b) {
  const Three<T> m{{Max(b[0], T(0)), Max(b[1], T(0)), Max(b[2], T(0))}};
  const T inv = T(1) / (m[0] + m[1] + m[2]);
  return {{m[0] * inv, m[1] * inv, m[2] * inv}};
}
template <class T>
COSPLAT_HD Three<T> PositivePartVjp(const Three<T>& b, const Three<T>& d) {
  const Three<T> m{{Max(b[0], T(0)), Max(b[1], T(0)), Max(b[2], T(0))}};
  const T inv = T(1) / (m[0] + m[1] + m[2]);
  const T mean = (d[0] * m[0] + d[1] * m[1] + d[2] * m[2]) * inv;
  Three<T> d_b;
  for (int i = 0; i < 3; ++i) d_b[i] = Select(b[i] > T(0), (d[i] - mean) * inv, T(0));
  return d_b;
}

// Signs that bring the three quaternions into the hemisphere of the one with the largest weight. At
// an edge this is one of the edge's endpoints, so that both adjacent triangles agree. The blend
// cannot cancel: its component along that quaternion is at least the largest weight, hence at least
// a third.
template <class T>
COSPLAT_HD Three<T> BlendSigns(const Three<Quat<T>>& q, const Three<T>& w) {
  const T d01 = HemisphereSign(q[0], q[1]);
  const T d02 = HemisphereSign(q[0], q[2]);
  const T d12 = HemisphereSign(q[1], q[2]);
  const auto first = w[0] >= Max(w[1], w[2]);
  const auto second = w[1] >= w[2];
  const T one(1);
  return {{Select(first, one, Select(second, d01, d02)),
           Select(first, d01, Select(second, one, d12)),
           Select(first, d02, Select(second, d12, one))}};
}
template <class T>
COSPLAT_HD Quat<T> SignedSum(const Three<Quat<T>>& q, const Three<T>& s, const Three<T>& w) {
  return q[0] * (s[0] * w[0]) + q[1] * (s[1] * w[1]) + q[2] * (s[2] * w[2]);
}
// w must be non-negative and sum to 1.
template <class T>
COSPLAT_HD Quat<T> BlendRotations(const Three<Quat<T>>& q, const Three<T>& w) {
  return Normalize(SignedSum(q, BlendSigns(q, w), w));
}
// Adds to d_q and d_w.
template <class T>
COSPLAT_HD void BlendRotationsVjp(const Three<Quat<T>>& q,
                                  const Three<T>& w,
                                  const Quat<T>& d,
                                  Three<Quat<T>>& d_q,
                                  Three<T>& d_w) {
  const Three<T> s = BlendSigns(q, w);
  const Quat<T> d_sum = NormalizeVjp(SignedSum(q, s, w), d);
  for (int i = 0; i < 3; ++i) {
    d_q[i] = d_q[i] + d_sum * (s[i] * w[i]);
    d_w[i] = d_w[i] + s[i] * Dot(q[i], d_sum);
  }
}

// Log of the isotropic scale by which a surface element has grown: log(clamp(A / A0)) / 2; 0 where
// the canonical area is zero.
template <class T>
COSPLAT_HD T ScaleShift(const T& area, const T& canonical) {
  const auto ok = canonical > T(1e-30f);
  const T ratio = Select(ok, area / Select(ok, canonical, T(1)), T(1));
  return T(0.5f) * Log(Clamp(ratio, T(kMinAreaRatio), T(kMaxAreaRatio)));
}
// Adds to d_area and d_canonical; nothing where clamped.
template <class T>
COSPLAT_HD void ScaleShiftVjp(
    const T& area, const T& canonical, const T& d, T& d_area, T& d_canonical) {
  const auto ok = canonical > T(1e-30f);
  const T safe = Select(ok, canonical, T(1));
  const T ratio = Select(ok, area / safe, T(0));
  const T half =
      Select(ratio > T(kMinAreaRatio), Select(ratio < T(kMaxAreaRatio), T(0.5f) * d, T(0)), T(0));
  d_area = d_area + half / (safe * Max(ratio, T(kMinAreaRatio)));
  d_canonical = d_canonical - half / safe;
}

template <class T>
COSPLAT_HD Vec3<T> Blend(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c, const Three<T>& w) {
  return a * w[0] + b * w[1] + c * w[2];
}
template <class T>
COSPLAT_HD T Blend(const Three<T>& x, const Three<T>& w) {
  return x[0] * w[0] + x[1] * w[1] + x[2] * w[2];
}

// `canonical_area`: SurfaceVertex::area of the canonical mesh.
template <class T>
COSPLAT_HD PosedGaussian<T> Embed(const Three<SurfaceVertex<T>>& v,
                                  const Three<T>& canonical_area,
                                  const EmbeddedGaussian<T>& g) {
  const Three<T> b = BarycentricOf(g), w = PositivePart(b);
  const Vec3<T> n = Normalize(Blend(v[0].normal, v[1].normal, v[2].normal, b));
  const Quat<T> q = BlendRotations({{v[0].rotation, v[1].rotation, v[2].rotation}}, w);
  const T shift =
      ScaleShift(Blend(Three<T>{{v[0].area, v[1].area, v[2].area}}, w), Blend(canonical_area, w));
  return {Blend(v[0].position, v[1].position, v[2].position, b) + n * g.offset.z,
          Multiply(q, g.rotation),
          g.scale_log + Vec3<T>{shift, shift, shift},
          q};
}

// Derivative of Embed: overwrites d_g, with zero for the barycentrics; adds to `d_v` unless null.
template <class T>
COSPLAT_HD void EmbedVjp(const Three<SurfaceVertex<T>>& v,
                         const Three<T>& canonical_area,
                         const EmbeddedGaussian<T>& g,
                         const PosedGaussian<T>& d,
                         EmbeddedGaussian<T>& d_g,
                         Three<SurfaceVertex<T>>* d_v) {
  const Three<T> b = BarycentricOf(g), w = PositivePart(b);
  const T zero(0);
  Three<T> d_b{{Dot(v[0].position, d.position),
                Dot(v[1].position, d.position),
                Dot(v[2].position, d.position)}};
  // mu = ... + d * n
  const Vec3<T> sum = Blend(v[0].normal, v[1].normal, v[2].normal, b);
  const Vec3<T> d_sum = NormalizeVjp(sum, d.position * g.offset.z);
  for (int i = 0; i < 3; ++i) d_b[i] = d_b[i] + Dot(v[i].normal, d_sum);
  // rotation = q (x) q_local, frame = q
  const Three<Quat<T>> rotations{{v[0].rotation, v[1].rotation, v[2].rotation}};
  Quat<T> d_q = d.frame;
  d_g.rotation = {zero, zero, zero, zero};
  MultiplyVjp(BlendRotations(rotations, w), g.rotation, d.rotation, d_q, d_g.rotation);
  Three<Quat<T>> d_rotations{};
  Three<T> d_w{{zero, zero, zero}};
  BlendRotationsVjp(rotations, w, d_q, d_rotations, d_w);
  // scale
  const T area = Blend(Three<T>{{v[0].area, v[1].area, v[2].area}}, w);
  T d_area = zero, d_canonical = zero;
  ScaleShiftVjp(area,
                Blend(canonical_area, w),
                d.scale_log.x + d.scale_log.y + d.scale_log.z,
                d_area,
                d_canonical);
  for (int i = 0; i < 3; ++i)
    d_w[i] = d_w[i] + v[i].area * d_area + canonical_area[i] * d_canonical;
  const Three<T> d_cut = PositivePartVjp(b, d_w);
  for (int i = 0; i < 3; ++i) d_b[i] = d_b[i] + d_cut[i];
  d_g.barycentric[0] = d_g.barycentric[1] = zero;  // fixed between walks
  d_g.offset = {d_b[0] - d_b[2], d_b[1] - d_b[2], Dot(Normalize(sum), d.position)};
  d_g.scale_log = d.scale_log;
  if (!d_v) return;
  for (int i = 0; i < 3; ++i) {
    SurfaceVertex<T>& out = (*d_v)[i];
    out.position += d.position * b[i];
    out.normal += d_sum * b[i];
    out.rotation = out.rotation + d_rotations[i];
    out.area = out.area + d_area * w[i];
  }
}

COSPLAT_MATH_END
#endif

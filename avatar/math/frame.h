// A triangle's area, its frame, and the rotation that carries its canonical frame to the posed one.
//
// posed vertices -> per-face area vector and quaternion -> averaged to vertices by
// avatar/surface/kernels/surface.h. Face frame as in SplattingAvatar (Shao et al. 2024), section
// 3.1: e along the first edge, n x e, and the normal n.
#if defined(COSPLAT_AVATAR_MATH_FRAME_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_FRAME_H_
#undef COSPLAT_AVATAR_MATH_FRAME_H_
#else
#define COSPLAT_AVATAR_MATH_FRAME_H_
#endif

#include "splat/math/quat.h"

COSPLAT_MATH_BEGIN

// Normal times area; counter-clockwise faces point outwards.
template <class T>
COSPLAT_HD Vec3<T> AreaVector(const Vec3<T>& v0, const Vec3<T>& v1, const Vec3<T>& v2) {
  return Cross(v1 - v0, v2 - v0) * T(0.5f);
}
// Adds to d_v0, d_v1, d_v2.
template <class T>
COSPLAT_HD void AreaVectorVjp(const Vec3<T>& v0,
                              const Vec3<T>& v1,
                              const Vec3<T>& v2,
                              const Vec3<T>& d,
                              Vec3<T>& d_v0,
                              Vec3<T>& d_v1,
                              Vec3<T>& d_v2) {
  Vec3<T> d_a{T(0), T(0), T(0)}, d_b{T(0), T(0), T(0)};
  CrossVjp(v1 - v0, v2 - v0, d * T(0.5f), d_a, d_b);
  d_v1 += d_a;
  d_v2 += d_b;
  d_v0 += -(d_a + d_b);
}

template <class T>
COSPLAT_HD Mat3<T> MatrixOfColumns(const Vec3<T>& a, const Vec3<T>& b, const Vec3<T>& c) {
  return {{a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z}};
}

// Columns e = norm(v1 - v0), n x e, n = norm(e x (v2 - v0)): a rotation matrix. A collapsed
// triangle gives zero columns; the area by which it is weighted is zero too.
template <class T>
COSPLAT_HD Mat3<T> FaceFrame(const Vec3<T>& v0, const Vec3<T>& v1, const Vec3<T>& v2) {
  const Vec3<T> e = Normalize(v1 - v0);
  const Vec3<T> n = Normalize(Cross(e, v2 - v0));
  return MatrixOfColumns(e, Cross(n, e), n);
}
// Adds to d_v0, d_v1, d_v2.
template <class T>
COSPLAT_HD void FaceFrameVjp(const Vec3<T>& v0,
                             const Vec3<T>& v1,
                             const Vec3<T>& v2,
                             const Mat3<T>& d,
                             Vec3<T>& d_v0,
                             Vec3<T>& d_v1,
                             Vec3<T>& d_v2) {
  const Vec3<T> a = v1 - v0, b = v2 - v0;
  const Vec3<T> e = Normalize(a);
  const Vec3<T> c = Cross(e, b);
  const Vec3<T> n = Normalize(c);
  Vec3<T> d_e{d(0, 0), d(1, 0), d(2, 0)}, d_n{d(0, 2), d(1, 2), d(2, 2)};
  Vec3<T> d_b{T(0), T(0), T(0)};
  CrossVjp(n, e, Vec3<T>{d(0, 1), d(1, 1), d(2, 1)}, d_n, d_e);
  CrossVjp(e, b, NormalizeVjp(c, d_n), d_e, d_b);
  const Vec3<T> d_a = NormalizeVjp(a, d_e);
  d_v1 += d_a;
  d_v2 += d_b;
  d_v0 += -(d_a + d_b);
}

// The rows of 4 q q^T, which is linear in R(q). For every rotation the row of the largest diagonal
// entry has norm at least 2, so that normalising it is stable. Rows 0 to 3 belong to w, x, y, z.
template <class T>
struct QuatRows {
  Quat<T> row[4];

  COSPLAT_HD explicit QuatRows(const Mat3<T>& m) {
    const T one(1);
    const T wx = m(2, 1) - m(1, 2), wy = m(0, 2) - m(2, 0), wz = m(1, 0) - m(0, 1);
    const T xy = m(1, 0) + m(0, 1), xz = m(0, 2) + m(2, 0), yz = m(2, 1) + m(1, 2);
    row[0] = {one + m(0, 0) + m(1, 1) + m(2, 2), wx, wy, wz};
    row[1] = {wx, one + m(0, 0) - m(1, 1) - m(2, 2), xy, xz};
    row[2] = {wy, xy, one - m(0, 0) + m(1, 1) - m(2, 2), yz};
    row[3] = {wz, xz, yz, one - m(0, 0) - m(1, 1) + m(2, 2)};
  }
  // Selects the argument for the row of the largest diagonal entry; the first of equal ones.
  COSPLAT_HD T OfLargest(const T& w, const T& x, const T& y, const T& z) const {
    const T &ww = row[0].w, &xx = row[1].x, &yy = row[2].y, &zz = row[3].z;
    return Select(
        ww >= Max(xx, Max(yy, zz)), w, Select(xx >= Max(yy, zz), x, Select(yy >= zz, y, z)));
  }
  COSPLAT_HD Quat<T> Largest() const {
    return {OfLargest(row[0].w, row[1].w, row[2].w, row[3].w),
            OfLargest(row[0].x, row[1].x, row[2].x, row[3].x),
            OfLargest(row[0].y, row[1].y, row[2].y, row[3].y),
            OfLargest(row[0].z, row[1].z, row[2].z, row[3].z)};
  }
};

// Unit quaternion q with R(q) = m, for a rotation matrix m; either sign.
template <class T>
COSPLAT_HD Quat<T> QuatOfRotation(const Mat3<T>& m) {
  return Normalize(QuatRows<T>(m).Largest());
}
// The entries of m are treated as nine independent numbers.
template <class T>
COSPLAT_HD Mat3<T> QuatOfRotationVjp(const Mat3<T>& m, const Quat<T>& d) {
  const QuatRows<T> rows(m);
  const Quat<T> r = NormalizeVjp(rows.Largest(), d);
  const Mat3<T> w{{r.w, -r.z, r.y, r.z, r.w, -r.x, -r.y, r.x, r.w}};
  const Mat3<T> x{{r.x, r.y, r.z, r.y, -r.x, -r.w, r.z, r.w, -r.x}};
  const Mat3<T> y{{-r.y, r.x, r.w, r.x, r.y, r.z, -r.w, r.z, -r.y}};
  const Mat3<T> z{{-r.z, -r.w, r.x, r.w, -r.z, r.y, r.x, r.y, r.z}};
  Mat3<T> d_m;
  for (int i = 0; i < 9; ++i) d_m.m[i] = rows.OfLargest(w.m[i], x.m[i], y.m[i], z.m[i]);
  return d_m;
}

// The rotation of a face from its canonical frame to the posed triangle.
template <class T>
COSPLAT_HD Quat<T> FaceRotation(const Vec3<T>& v0,
                                const Vec3<T>& v1,
                                const Vec3<T>& v2,
                                const Mat3<T>& canonical_frame) {
  return QuatOfRotation(FaceFrame(v0, v1, v2) * Transpose(canonical_frame));
}
// Adds to d_v0, d_v1, d_v2. The canonical frame is fixed.
template <class T>
COSPLAT_HD void FaceRotationVjp(const Vec3<T>& v0,
                                const Vec3<T>& v1,
                                const Vec3<T>& v2,
                                const Mat3<T>& canonical_frame,
                                const Quat<T>& d,
                                Vec3<T>& d_v0,
                                Vec3<T>& d_v1,
                                Vec3<T>& d_v2) {
  const Mat3<T> rotation = FaceFrame(v0, v1, v2) * Transpose(canonical_frame);
  FaceFrameVjp(v0, v1, v2, QuatOfRotationVjp(rotation, d) * canonical_frame, d_v0, d_v1, d_v2);
}

// The sign that brings q into a's hemisphere; q and -q are the same rotation.
template <class T>
COSPLAT_HD T HemisphereSign(const Quat<T>& a, const Quat<T>& q) {
  return Select(Dot(a, q) < T(0), T(-1), T(1));
}

COSPLAT_MATH_END
#endif

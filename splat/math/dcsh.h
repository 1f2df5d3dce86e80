// View-dependent colour: real spherical harmonics as polynomials in the direction cosines
// u = (x, y, z), computed by two recurrences without trigonometry.
//
// With (x + iy)^m = rho^m e^{i m phi} and P_l^m(z) = rho^m Q_l^m(z) (Q_l^m the m-th derivative of
// the Legendre polynomial P_l), every real basis function is
//   Y_l^m = K * Q_l^|m|(z) * { sqrt2 Re (x+iy)^m | 1 | sqrt2 Im (x+iy)^|m| }  for m > 0, = 0, < 0,
// with no singular direction. Coefficients are in 3DGS's order: l^2 + l + m. The bases differ in
// their constants (splat/basis_constants.h), and one of them applies Fold to u; see docs/dcsh.md.
#if defined(COSPLAT_SPLAT_MATH_DCSH_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_DCSH_H_
#undef COSPLAT_SPLAT_MATH_DCSH_H_
#else
#define COSPLAT_SPLAT_MATH_DCSH_H_
#endif

#include "splat/basis_constants.h"
#include "splat/math/vec.h"

COSPLAT_MATH_BEGIN

// Q_l^m(z) for 0 <= m <= l <= kDegree, and Re, Im of (x + iy)^m.
template <int kDegree, class T>
struct BasisParts {
  T q[kDegree + 2][kDegree + 2];  // q[l][m]; q[l][m > l] = 0
  T re[kDegree + 1];
  T im[kDegree + 1];
};

// (l - m) Q_l^m = (2l - 1) z Q_{l-1}^m - (l + m - 1) Q_{l-2}^m, from Q_m^m = (2m - 1)!!.
template <int kDegree, class T>
COSPLAT_HD BasisParts<kDegree, T> EvaluateParts(const Vec3<T>& u) {
  BasisParts<kDegree, T> p;
  p.re[0] = T(1);
  p.im[0] = T(0);
  for (int m = 0; m < kDegree; ++m) {
    p.re[m + 1] = u.x * p.re[m] - u.y * p.im[m];
    p.im[m + 1] = u.x * p.im[m] + u.y * p.re[m];
  }
  float diagonal = 1;
  for (int m = 0; m <= kDegree + 1; ++m) {
    for (int l = 0; l < m && l <= kDegree; ++l) p.q[l][m] = T(0);
    if (m > kDegree) break;
    p.q[m][m] = T(diagonal);
    if (m < kDegree) p.q[m + 1][m] = T(diagonal * float(2 * m + 1)) * u.z;
    for (int l = m + 2; l <= kDegree; ++l)
      p.q[l][m] =
          T(2 * l - 1) / T(l - m) * u.z * p.q[l - 1][m] - T(l + m - 1) / T(l - m) * p.q[l - 2][m];
    diagonal *= float(2 * m + 1);
  }
  return p;
}

// basis[(kDegree+1)^2] at the unit vector u. `constants`: BasisConstants(basis).
template <int kDegree, class T>
COSPLAT_HD void EvaluateBasis(const Vec3<T>& u, const float* constants, T* basis) {
  const BasisParts<kDegree, T> p = EvaluateParts<kDegree>(u);
  for (int l = 0; l <= kDegree; ++l) {
    const int center = l * l + l;
    basis[center] = T(constants[center]) * p.q[l][0];
    for (int m = 1; m <= l; ++m) {
      basis[center + m] = T(constants[center + m]) * p.q[l][m] * p.re[m];
      basis[center - m] = T(constants[center - m]) * p.q[l][m] * p.im[m];
    }
  }
}

// d_u (with x, y, z independent: chain with NormalizeVjp) given weights[k] = dL/d basis[k].
// dQ_l^m/dz = Q_l^{m+1};  d(x+iy)^m/dx = m (x+iy)^{m-1},  d/dy = i m (x+iy)^{m-1}.
template <int kDegree, class T>
COSPLAT_HD Vec3<T> EvaluateBasisVjp(const Vec3<T>& u, const float* constants, const T* weights) {
  const BasisParts<kDegree, T> p = EvaluateParts<kDegree>(u);
  Vec3<T> d{T(0), T(0), T(0)};
  for (int l = 1; l <= kDegree; ++l) {
    const int center = l * l + l;
    d.z += T(constants[center]) * weights[center] * p.q[l][1];
    for (int m = 1; m <= l; ++m) {
      const T a = T(constants[center + m]) * weights[center + m];
      const T b = T(constants[center - m]) * weights[center - m];
      const T k = T(float(m)) * p.q[l][m];
      d.x += k * (a * p.re[m - 1] + b * p.im[m - 1]);
      d.y += k * (b * p.re[m - 1] - a * p.im[m - 1]);
      const T dq = m < l ? p.q[l][m + 1] : T(0);
      d.z += dq * (a * p.re[m] + b * p.im[m]);
    }
  }
  return d;
}

// The effect of arctan(y/x) on a direction: it loses the quadrant, so that cos and sin of m times
// it are those of the azimuth of (|x|, sgn(x) y). At x = 0, for either sign of the zero, it is
// arctan(+inf or -inf) of y/+0, so y stays. On the z axis there is no azimuth (0/0), and every
// function that depends on it is 0.
template <class T>
COSPLAT_HD Vec3<T> Fold(const Vec3<T>& u) {
  const T sign = Select(u.x < T(0), T(-1), T(1));
  return {sign * u.x, sign * u.y, u.z};
}
// Fold has no derivative at its jump at x = 0; this is the derivative on either side.
template <class T>
COSPLAT_HD Vec3<T> FoldVjp(const Vec3<T>& u, const Vec3<T>& d) {
  const T sign = Select(u.x < T(0), T(-1), T(1));
  return {sign * d.x, sign * d.y, d.z};
}

// Colour seen along the unit vector u: max(0, 1/2 + sum_k c_k Y_k(u)) per channel (3DGS).
// dc[3]; rest[K-1][3] of which the first (kDegree+1)^2 - 1 are used.
template <int kDegree, class T>
COSPLAT_HD Vec3<T> EvaluateColor(const Vec3<T>& u,
                                 const float* constants,
                                 const T* dc,
                                 const T* rest) {
  T basis[(kDegree + 1) * (kDegree + 1)];
  EvaluateBasis<kDegree>(u, constants, basis);
  T c[3];
  for (int i = 0; i < 3; ++i) c[i] = T(0.5f) + basis[0] * dc[i];
  for (int k = 1; k < (kDegree + 1) * (kDegree + 1); ++k)
    for (int i = 0; i < 3; ++i) c[i] += basis[k] * rest[3 * (k - 1) + i];
  // Written so that a NaN propagates instead of becoming black; minus infinity becomes NaN.
  for (T& x : c) x = Select(x < T(0), x - x, x);
  return {c[0], c[1], c[2]};
}

// Writes d_dc[3] and the used part of d_rest; returns d_u. A channel clamped to 0 has no gradient.
template <int kDegree, class T>
COSPLAT_HD Vec3<T> EvaluateColorVjp(const Vec3<T>& u,
                                    const float* constants,
                                    const T* rest,
                                    const Vec3<T>& color,
                                    const Vec3<T>& d_color,
                                    T* d_dc,
                                    T* d_rest) {
  constexpr int kCount = (kDegree + 1) * (kDegree + 1);
  T basis[kCount];
  EvaluateBasis<kDegree>(u, constants, basis);
  const T d[3] = {Select(color.x > T(0), d_color.x, T(0)),
                  Select(color.y > T(0), d_color.y, T(0)),
                  Select(color.z > T(0), d_color.z, T(0))};
  T weights[kCount];
  weights[0] = T(0);
  for (int i = 0; i < 3; ++i) d_dc[i] = basis[0] * d[i];
  for (int k = 1; k < kCount; ++k) {
    const T* c = rest + 3 * (k - 1);
    weights[k] = c[0] * d[0] + c[1] * d[1] + c[2] * d[2];
    for (int i = 0; i < 3; ++i) d_rest[3 * (k - 1) + i] = basis[k] * d[i];
  }
  return EvaluateBasisVjp<kDegree>(u, constants, weights);
}

COSPLAT_MATH_END
#endif

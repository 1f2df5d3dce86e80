// The colour basis `dcsh` in terms of angles, in the two forms found in the literature, for
// comparison with the polynomials of splat/math/dcsh.h. In long double, with angles that are
// accurate near the poles, it is the reference for all forms.
//
// Not used for rendering. Same constants and order as splat/math/dcsh.h.
#if defined(COSPLAT_SPLAT_STUDY_NAIVE_BASIS_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_STUDY_NAIVE_BASIS_H_
#undef COSPLAT_SPLAT_STUDY_NAIVE_BASIS_H_
#else
#define COSPLAT_SPLAT_STUDY_NAIVE_BASIS_H_
#endif

#include <cmath>

#include "splat/math/vec.h"

COSPLAT_MATH_BEGIN

// For scalars; packs define their own (apps/study/stability/basis_packs.cpp).
#define COSPLAT_STUDY_FUNCTIONS(T)                          \
  COSPLAT_HD T Acos(T x) { return std::acos(x); }           \
  COSPLAT_HD T Atan(T x) { return std::atan(x); }           \
  COSPLAT_HD T Atan2(T y, T x) { return std::atan2(y, x); } \
  COSPLAT_HD T SquareRoot(T x) { return std::sqrt(x); }
COSPLAT_STUDY_FUNCTIONS(float)
COSPLAT_STUDY_FUNCTIONS(double)
COSPLAT_STUDY_FUNCTIONS(long double)
#undef COSPLAT_STUDY_FUNCTIONS
COSPLAT_HD long double Sin(long double x) { return std::sin(x); }
COSPLAT_HD long double Cos(long double x) { return std::cos(x); }

// A direction as angles: z = cos(theta), s = sin(theta), phi.
template <class T>
struct Angles {
  T z, s, phi;
};

// As written in DCSHARP: P_l^m(u_z) and exp(i m arctan(u_y / u_x)).
template <class T>
COSPLAT_HD Angles<T> LiteralAngles(const Vec3<T>& u) {
  return {u.z, SquareRoot(T(1) - u.z * u.z), Atan(u.y / u.x)};
}

// As in textbooks: theta = acos(z), phi = atan2(y, x).
template <class T>
COSPLAT_HD Angles<T> TextbookAngles(const Vec3<T>& u) {
  const T theta = Acos(u.z);
  return {Cos(theta), Sin(theta), Atan2(u.y, u.x)};
}

// Without the cancellation in 1 - z^2 and the ill-conditioned end of acos. For the reference.
template <class T>
COSPLAT_HD Angles<T> ExactAngles(const Vec3<T>& u) {
  const T s = SquareRoot(u.x * u.x + u.y * u.y);
  return {u.z, s, Atan2(u.y, u.x)};
}

// p[l][m] = P_l^m(z) without Condon-Shortley sign, 0 <= m <= l.
template <int kDegree, class T>
COSPLAT_HD void AssociatedLegendre(const Angles<T>& a, T (&p)[kDegree + 1][kDegree + 1]) {
  p[0][0] = T(1);
  for (int m = 0; m <= kDegree; ++m) {
    if (m > 0) p[m][m] = T(float(2 * m - 1)) * a.s * p[m - 1][m - 1];
    if (m < kDegree) p[m + 1][m] = T(float(2 * m + 1)) * a.z * p[m][m];
    for (int l = m + 2; l <= kDegree; ++l)
      p[l][m] = (T(float(2 * l - 1)) * a.z * p[l - 1][m] - T(float(l + m - 1)) * p[l - 2][m]) *
                (T(1) / T(float(l - m)));
  }
}

// basis[(kDegree+1)^2]; `constants` as in BasisConstants(Basis::kDcsh), in any precision.
template <int kDegree, class T, class Constant>
COSPLAT_HD void BasisAtAngles(const Angles<T>& a, const Constant* constants, T* basis) {
  T p[kDegree + 1][kDegree + 1];
  AssociatedLegendre<kDegree>(a, p);
  for (int m = 0; m <= kDegree; ++m) {
    const T c = m > 0 ? Cos(T(float(m)) * a.phi) : T(1);
    const T s = m > 0 ? Sin(T(float(m)) * a.phi) : T(0);
    for (int l = m; l <= kDegree; ++l) {
      const int center = l * l + l;
      if (m > 0) basis[center - m] = T(constants[center - m]) * p[l][m] * s;
      basis[center + m] = T(constants[center + m]) * p[l][m] * c;
    }
  }
}

// d_u of BasisAtAngles(TextbookAngles(u)) by the chain rule through both angles, given
// weights[k] = dL/d basis[k]: dP/dtheta = (l z P_l^m - (l + m) P_{l-1}^m) / s,
// dtheta/dz = -1/sqrt(1 - z^2), dphi/d(x, y) = (-y, x) / (x^2 + y^2).
template <int kDegree, class T>
COSPLAT_HD Vec3<T> TextbookBasisVjp(const Vec3<T>& u, const float* constants, const T* weights) {
  const Angles<T> a = TextbookAngles(u);
  T p[kDegree + 1][kDegree + 1], d_theta = T(0), d_phi = T(0);
  AssociatedLegendre<kDegree>(a, p);
  for (int l = 1; l <= kDegree; ++l)
    for (int m = 0; m <= l; ++m) {
      const int center = l * l + l;
      const T c = Cos(T(float(m)) * a.phi), s = Sin(T(float(m)) * a.phi);
      const T even = T(constants[center + m]) * weights[center + m];
      const T odd = m > 0 ? T(constants[center - m]) * weights[center - m] : T(0);
      const T below = m < l ? p[l - 1][m] : T(0);
      const T slope = (T(float(l)) * a.z * p[l][m] - T(float(l + m)) * below) / a.s;
      d_theta += slope * (even * c + odd * s);
      d_phi += T(float(m)) * p[l][m] * (odd * c - even * s);
    }
  const T rho2 = u.x * u.x + u.y * u.y;
  return {d_phi * (-u.y / rho2), d_phi * (u.x / rho2), -d_theta / SquareRoot(T(1) - u.z * u.z)};
}

// max(0, 1/2 + sum_k c_k Y_k), as EvaluateColor (splat/math/dcsh.h), for a given basis.
template <int kDegree, class T, class Coefficient>
COSPLAT_HD Vec3<T> ColorOfBasis(const T* basis, const Coefficient* dc, const Coefficient* rest) {
  T c[3];
  for (int i = 0; i < 3; ++i) c[i] = T(0.5f) + basis[0] * T(dc[i]);
  for (int k = 1; k < (kDegree + 1) * (kDegree + 1); ++k)
    for (int i = 0; i < 3; ++i) c[i] += basis[k] * T(rest[3 * (k - 1) + i]);
  for (T& x : c) x = Select(x < T(0), T(0), x);
  return {c[0], c[1], c[2]};
}

COSPLAT_MATH_END
#endif

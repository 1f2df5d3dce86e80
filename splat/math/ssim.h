// Structural similarity at one pixel from local moments (Wang et al. 2004, eq. 13), and its
// derivative with respect to them.
//
// With u = x + y and v = x - y, the products of eq. 13 are sums and differences of squares:
// 4 mu_x mu_y = mu_u^2 - mu_v^2 and 4 cov = var_u - var_v, so that four windowed means suffice
// instead of the five of x, y, x^2, y^2 and x y.
#if defined(COSPLAT_SPLAT_MATH_SSIM_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_SSIM_H_
#undef COSPLAT_SPLAT_MATH_SSIM_H_
#else
#define COSPLAT_SPLAT_MATH_SSIM_H_
#endif

#include "splat/math/scalar.h"

COSPLAT_MATH_BEGIN

// Window: Gaussian, sigma 1.5 px, 11 x 11, zero beyond the border (3DGS). Values in [0, 1].
constexpr int kSsimRadius = 5;
constexpr float kSsimSigma = 1.5f;
constexpr float kSsimC1 = 0.01f * 0.01f;
constexpr float kSsimC2 = 0.03f * 0.03f;

// One axis of the symmetric window: weights[k] is the weight of both taps k away from the centre.
COSPLAT_HD void SsimWindow(float (&weights)[kSsimRadius + 1]) {
  float sum = 0;
  for (int k = 0; k <= kSsimRadius; ++k) {
    weights[k] = Exp(-float(k * k) / (2 * kSsimSigma * kSsimSigma));
    sum += k == 0 ? weights[k] : 2 * weights[k];
  }
  for (float& w : weights) w /= sum;
}

// Windowed means of u, v, u^2 and v^2.
template <class T>
struct SsimMoments {
  T u, v, uu, vv;
};

// The four factors of SSIM = a1 a2 / (b1 b2).
template <class T>
struct SsimTerms {
  T a1, a2, b1, b2;
};

// Variances are clamped to 0: on constant images, rounding makes them slightly negative.
template <class T>
COSPLAT_HD SsimTerms<T> SsimTermsOf(const SsimMoments<T>& m) {
  const T half(0.5f), uu = m.u * m.u, vv = m.v * m.v;
  const T var_u = Max(m.uu - uu, T(0)), var_v = Max(m.vv - vv, T(0));
  return {half * (uu - vv) + T(kSsimC1),
          half * (var_u - var_v) + T(kSsimC2),
          half * (uu + vv) + T(kSsimC1),
          half * (var_u + var_v) + T(kSsimC2)};
}

template <class T>
COSPLAT_HD T Ssim(const SsimMoments<T>& m) {
  const SsimTerms<T> s = SsimTermsOf(m);
  return s.a1 * s.a2 * (T(1) / (s.b1 * s.b2));
}

// d/d(u^2, v^2) and d/du + d/dv, since a change of x moves u's and v's means alike. For d_ssim = 1.
template <class T>
struct SsimPartials {
  T mean, uu, vv;
};
template <class T>
COSPLAT_HD SsimPartials<T> SsimVjp(const SsimMoments<T>& m) {
  const SsimTerms<T> s = SsimTermsOf(m);
  const T half(0.5f), inv = T(1) / (s.b1 * s.b2);
  const T ssim_inv = s.a1 * s.a2 * inv * inv;                       // SSIM / (b1 b2)
  const T d_a1 = half * s.a2 * inv, d_b1 = half * ssim_inv * s.b2;  // the latter negated
  const T d_a2 = half * s.a1 * inv, d_b2 = half * ssim_inv * s.b1;
  const T d_uu = Select(m.uu - m.u * m.u > T(0), d_a2 - d_b2, T(0));
  const T d_vv = Select(m.vv - m.v * m.v > T(0), -(d_a2 + d_b2), T(0));
  return {T(2) * (m.u * (d_a1 - d_b1 - d_uu) - m.v * (d_a1 + d_b1 + d_vv)), d_uu, d_vv};
}

COSPLAT_MATH_END
#endif

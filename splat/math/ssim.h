// Structural similarity at one pixel from local moments (Wang et al. 2004, eq. 13), and its
// derivative with respect to the moments of the first image.
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
constexpr float kSsimC1 = 0.01f * 0.01f;
constexpr float kSsimC2 = 0.03f * 0.03f;

// Windowed means of x, y, x^2, y^2 and x y.
template <class T>
struct SsimMoments {
  T x, y, xx, yy, xy;
};

// Variances are clamped at 0: on constant images rounding makes them slightly negative.
template <class T>
COSPLAT_HD T Ssim(const SsimMoments<T>& m) {
  const T var_x = Max(m.xx - m.x * m.x, T(0));
  const T var_y = Max(m.yy - m.y * m.y, T(0));
  const T cov = m.xy - m.x * m.y;
  const T a1 = T(2) * m.x * m.y + T(kSsimC1);
  const T a2 = T(2) * cov + T(kSsimC2);
  const T b1 = m.x * m.x + m.y * m.y + T(kSsimC1);
  const T b2 = var_x + var_y + T(kSsimC2);
  return (a1 * a2) / (b1 * b2);
}

// d/d(x, xx, xy) for d_ssim = 1.
template <class T>
struct SsimPartials {
  T x, xx, xy;
};
template <class T>
COSPLAT_HD SsimPartials<T> SsimVjp(const SsimMoments<T>& m) {
  const T raw_var_x = m.xx - m.x * m.x;
  const T free_x = Select(raw_var_x > T(0), T(1), T(0));
  const T var_y = Max(m.yy - m.y * m.y, T(0));
  const T a1 = T(2) * m.x * m.y + T(kSsimC1);
  const T a2 = T(2) * (m.xy - m.x * m.y) + T(kSsimC2);
  const T b1 = m.x * m.x + m.y * m.y + T(kSsimC1);
  const T b2 = Max(raw_var_x, T(0)) + var_y + T(kSsimC2);
  const T inv = T(1) / (b1 * b2);
  const T d_cov = T(2) * a1 * inv;
  const T d_var_x = -(a1 * a2 * inv / b2) * free_x;
  const T d_mean = T(2) * m.y * a2 * inv - T(2) * m.x * (a1 * a2 * inv / b1);
  return {d_mean - T(2) * m.x * d_var_x - m.y * d_cov, d_var_x, d_cov};
}

COSPLAT_MATH_END
#endif

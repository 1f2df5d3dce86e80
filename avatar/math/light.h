// Light that stands still in the world while the head turns in it.
//
// The logarithm of the light that a surface gets is a polynomial of second degree of its normal in
// the world, with coefficients l per channel that all Gaussians share:
//   y_k   = sum_c w_c Y_k(N_c)               N: unit normals at the triangle's vertices
//   s     = sum_k l_k y_k                    w: the Gaussian's barycentrics on it
//   lit   = exp(s) (0.5 + K0 dc)             its base colour
// Bands >= 1 of the colour are added to it unlit.
//
// That light varies as a polynomial of second degree over normals: Ramamoorthi & Hanrahan 2001 ("On
// the relationship between radiance and irradiance"). Its logarithm is one here, so that it stays
// positive and a display's gamma only scales the coefficients. The constant term is part of the
// Gaussians' colours.
#if defined(COSPLAT_AVATAR_MATH_LIGHT_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_LIGHT_H_
#undef COSPLAT_AVATAR_MATH_LIGHT_H_
#else
#define COSPLAT_AVATAR_MATH_LIGHT_H_
#endif

#include "splat/math/vec.h"

COSPLAT_MATH_BEGIN

constexpr int kLightTerms = 8;
// The largest coefficient. A light of them all changes by a factor of e^22 at most, so that colours
// stay finite; videos have coefficients below 1.
constexpr float kMaxLight = 5;

template <class T>
struct LightTerms {
  T y[kLightTerms];
};

// Y of a normal.
template <class T>
COSPLAT_HD LightTerms<T> LightTermsOf(const Vec3<T>& n) {
  return {{n.x,
           n.y,
           n.z,
           n.x * n.y,
           n.y * n.z,
           n.x * n.z,
           n.x * n.x - n.y * n.y,
           n.z * n.z - T(1.0f / 3)}};
}
template <class T>
COSPLAT_HD Vec3<T> LightTermsOfVjp(const Vec3<T>& n, const LightTerms<T>& d) {
  return {d.y[0] + d.y[3] * n.y + d.y[5] * n.z + T(2) * d.y[6] * n.x,
          d.y[1] + d.y[3] * n.x + d.y[4] * n.z - T(2) * d.y[6] * n.y,
          d.y[2] + d.y[4] * n.y + d.y[5] * n.x + T(2) * d.y[7] * n.z};
}

// s. light: [kLightTerms, 3] coefficients of red, green and blue.
template <class T>
COSPLAT_HD Vec3<T> LogLight(const LightTerms<T>& terms, const float* light) {
  const T zero(0.0f);
  Vec3<T> s{zero, zero, zero};
  for (int k = 0; k < kLightTerms; ++k)
    s += Vec3<T>{T(light[3 * k]), T(light[3 * k + 1]), T(light[3 * k + 2])} * terms.y[k];
  return s;
}
// The derivative for the terms; that for coefficient [k][channel] is terms.y[k] * d[channel].
template <class T>
COSPLAT_HD LightTerms<T> LogLightVjp(const float* light, const Vec3<T>& d) {
  LightTerms<T> d_terms;
  for (int k = 0; k < kLightTerms; ++k)
    d_terms.y[k] = Dot(Vec3<T>{T(light[3 * k]), T(light[3 * k + 1]), T(light[3 * k + 2])}, d);
  return d_terms;
}

// Coefficient dc of the lit base colour. black: that of black, -0.5 / K0.
template <class T>
COSPLAT_HD Vec3<T> Lit(const Vec3<T>& dc, const Vec3<T>& log_light, float black) {
  const T b(black);
  return {b + Exp(log_light.x) * (dc.x - b),
          b + Exp(log_light.y) * (dc.y - b),
          b + Exp(log_light.z) * (dc.z - b)};
}
// Overwrites d_dc and d_log_light.
template <class T>
COSPLAT_HD void LitVjp(const Vec3<T>& dc,
                       const Vec3<T>& log_light,
                       float black,
                       const Vec3<T>& d,
                       Vec3<T>& d_dc,
                       Vec3<T>& d_log_light) {
  d_dc = {Exp(log_light.x) * d.x, Exp(log_light.y) * d.y, Exp(log_light.z) * d.z};
  d_log_light = {
      d_dc.x * (dc.x - T(black)), d_dc.y * (dc.y - T(black)), d_dc.z * (dc.z - T(black))};
}

COSPLAT_MATH_END
#endif

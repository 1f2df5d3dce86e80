// Alpha of a projected Gaussian at a pixel, and front-to-back blending over a background. Source:
// Kerbl et al. 2023, eq. 2-4. The blend loops of both back ends call these functions.
//
// The backward pass also runs front to back: besides the transmittance it tracks the part of
// dot(dL/dC, C) that lies behind the current splat, so nothing is stored per pixel between passes.
#if defined(COSPLAT_SPLAT_MATH_BLEND_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_BLEND_H_
#undef COSPLAT_SPLAT_MATH_BLEND_H_
#else
#define COSPLAT_SPLAT_MATH_BLEND_H_
#endif

#include "splat/config.h"
#include "splat/math/vec.h"

COSPLAT_MATH_BEGIN

// Exponent of a projected Gaussian at an offset (dx, dy) px from its centre, as a quadratic form:
//   power = xx dx^2 + xy dx dy + yy dy^2 = -1/2 d^T conic d, the -1/2 folded in.
template <class T>
struct PowerForm {
  T xx, xy, yy;
};

template <class T>
COSPLAT_HD T PowerAt(const PowerForm<T>& form, T dx, T dy) {
  return (form.xx * dx + form.xy * dy) * dx + form.yy * dy * dy;
}

// The form about another point o: power(o + l) = value + d_x l_x + d_y l_y + PowerAt(form, l). When
// many pixels have the same few offsets l from different o, they share the last term.
template <class T>
struct PowerExpansion {
  T value, d_x, d_y;
};
template <class T>
COSPLAT_HD PowerExpansion<T> ExpandAt(const PowerForm<T>& form, T dx, T dy) {
  return {PowerAt(form, dx, dy),
          T(2) * form.xx * dx + form.xy * dy,
          T(2) * form.yy * dy + form.xy * dx};
}
template <class T>
COSPLAT_HD T PowerNear(const PowerExpansion<T>& e, T l_x, T l_y, T power_at_l) {
  return e.d_x * l_x + (e.d_y * l_y + (e.value + power_at_l));
}

// Where the exponent is highest along a row of pixels and along a column: at dx = x_per_y dy and at
// dy = y_per_x dx.
template <class T>
struct PowerRidges {
  T x_per_y, y_per_x;
};
template <class T>
COSPLAT_HD PowerRidges<T> RidgesOf(const PowerForm<T>& form) {
  return {T(-0.5f) * form.xy / form.xx, T(-0.5f) * form.xy / form.yy};
}

// The largest exponent in a rectangle, given by offsets from the centre. The form is negative
// definite, so the largest value lies on an edge that faces the centre: at the edge's own highest
// point or at the corner nearest to it. (The exact test of Speedy-Splat, Hanson et al. 2025.)
template <class T>
COSPLAT_HD T
LargestPowerIn(const PowerForm<T>& form, const PowerRidges<T>& ridges, T dx0, T dx1, T dy0, T dy1) {
  const T near_x = Clamp(T(0), dx0, dx1), near_y = Clamp(T(0), dy0, dy1);
  const T along_y = Clamp(ridges.y_per_x * near_x, dy0, dy1);
  const T along_x = Clamp(ridges.x_per_y * near_y, dx0, dx1);
  return Max(PowerAt(form, near_x, along_y), PowerAt(form, along_x, near_y));
}

// Moments over pixels, about the centre, of g = dL/d(opacity falloff) falloff. The gradients of the
// opacity (`one`) and, times the opacity, of the geometry follow from them.
template <class T>
struct PowerMoments {
  T one, x, y, xx, xy, yy;
};
template <class T>
COSPLAT_HD void Accumulate(T g, T dx, T dy, PowerMoments<T>& m) {
  const T gx = g * dx;
  const T gy = g * dy;
  m.one += g;
  m.x += gx;
  m.y += gy;
  m.xx += gx * dx;
  m.xy += gx * dy;
  m.yy += gy * dy;
}
// The moments after increasing every pixel's offset from the centre by (l_x, l_y).
template <class T>
COSPLAT_HD PowerMoments<T> MomentsMovedBy(const PowerMoments<T>& m, T l_x, T l_y) {
  const T x = m.x + l_x * m.one;
  const T y = m.y + l_y * m.one;
  return {m.one, x, y, m.xx + l_x * (m.x + x), m.xy + l_x * m.y + l_y * x, m.yy + l_y * (m.y + y)};
}
// Gradients of a projected Gaussian's centre, form and opacity from its moments. The centre's
// gradient changes sign since dx = pixel - centre.
template <class T>
struct ShapeGradient {
  T x, y, power_xx, power_xy, power_yy, opacity;
};
template <class T>
COSPLAT_HD ShapeGradient<T> ShapeVjp(const PowerForm<T>& form,
                                     T opacity,
                                     const PowerMoments<T>& m) {
  return {-opacity * (T(2) * form.xx * m.x + form.xy * m.y),
          -opacity * (T(2) * form.yy * m.y + form.xy * m.x),
          opacity * m.xx,
          opacity * m.xy,
          opacity * m.yy,
          m.one};
}

// The exponent below which a splat of this opacity contributes less than kMinAlpha.
template <class T>
COSPLAT_HD T RejectBelow(T opacity) {
  return Log(T(kMinAlpha) / opacity);
}

// min(kMaxAlpha, opacity * falloff), falloff = exp(power).
template <class T>
COSPLAT_HD T AlphaOf(T opacity, T falloff) {
  return Min(opacity * falloff, T(kMaxAlpha));
}
// Gradient of the uncapped product; zero where it was capped.
template <class T>
COSPLAT_HD T AlphaOfVjp(T opacity, T falloff, T d_alpha) {
  return Select(opacity * falloff < T(kMaxAlpha), d_alpha, T(0));
}

template <class T>
struct BlendState {
  T transmittance;
  Vec3<T> color;
};

// Whether a pixel accepts a splat: it is visible there and the pixel is not yet opaque.
template <class T>
COSPLAT_HD auto Accepts(T power, T reject_below, T transmittance) {
  return And(power >= reject_below, transmittance >= T(kMinTransmittance));
}

// Blends one splat behind the previous ones. Where it is not accepted, alpha must be 0, which
// leaves state and derivatives unchanged.
template <class T>
COSPLAT_HD void BlendBehind(T alpha, const Vec3<T>& color, BlendState<T>& state) {
  const T weight = alpha * state.transmittance;
  state.color += color * weight;
  state.transmittance = state.transmittance - weight;
}

// State of the backward pass at a pixel. `behind` starts as dot(d_pixel, final pixel), background
// included.
template <class T>
struct BlendVjpState {
  T transmittance;
  T behind;
};

template <class T>
struct BlendVjpResult {
  T weight;  // dL/d(color) = weight * d_pixel
  T d_alpha;
};

template <class T>
COSPLAT_HD BlendVjpResult<T> BlendBehindVjp(T alpha,
                                            const Vec3<T>& color,
                                            const Vec3<T>& d_pixel,
                                            BlendVjpState<T>& state) {
  const T weight = alpha * state.transmittance;
  const T gain = Dot(color, d_pixel);
  state.behind = state.behind - weight * gain;
  const T d_alpha = state.transmittance * gain - FastDivide(state.behind, T(1) - alpha);
  state.transmittance = state.transmittance - weight;
  return {weight, d_alpha};
}

// The colour that a pixel would lose without one splat, C(alpha) - C(0), per channel. The image is
// linear in each alpha, so this is exactly alpha dC/dalpha. `behind`: contribution of the splats
// behind it and the background; `transmittance`: in front of it.
template <class T>
COSPLAT_HD Vec3<T> LossWithout(T alpha,
                               const Vec3<T>& color,
                               const Vec3<T>& behind,
                               T transmittance) {
  return (color * transmittance - behind * FastDivide(T(1), T(1) - alpha)) * alpha;
}

// One pixel's part of a splat's Contribution (splat/render/contribution.h), without the opacity
// factor of `hits`; all zero where the splat is not accepted, and `falloff` must be 0 there.
// Advances the pixel past the splat: subtracts it from `behind` and attenuates `transmittance`.
template <class T>
struct PixelContribution {
  T weight, hits, sensitivity, change;
};
template <class T, class Mask>
COSPLAT_HD PixelContribution<T> ContributionBehind(
    Mask accept, T opacity, T falloff, const Vec3<T>& color, Vec3<T>& behind, T& transmittance) {
  const T alpha = AlphaOf(opacity, falloff), weight = alpha * transmittance, t = transmittance;
  behind = behind - color * weight;
  transmittance = t - weight;
  const Vec3<T> loss = LossWithout(alpha, color, behind, t);
  // d(sum of channels)/d(falloff) = loss / falloff.
  const T slope =
      Select(accept, FastDivide(loss.x + loss.y + loss.z, Max(falloff, T(1e-6f))), T(0));
  return {weight, Select(accept, t, T(0)), slope * slope, Dot(loss, loss)};
}

COSPLAT_MATH_END
#endif

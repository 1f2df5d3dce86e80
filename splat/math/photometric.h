// The values compared by the photometric loss (splat/train/loss/loss.h), and its pointwise terms.
#if defined(COSPLAT_SPLAT_MATH_PHOTOMETRIC_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_PHOTOMETRIC_H_
#undef COSPLAT_SPLAT_MATH_PHOTOMETRIC_H_
#else
#define COSPLAT_SPLAT_MATH_PHOTOMETRIC_H_
#endif

#include <cstdint>

#include "splat/math/scalar.h"

COSPLAT_MATH_BEGIN

// l1 |e| + mse e^2 of a value's error e = x - y.
template <class T>
COSPLAT_HD T Pointwise(T l1, T mse, const T& e) {
  return l1 * Max(e, -e) + mse * e * e;
}
// d_e; 0 at e = 0.
template <class T>
COSPLAT_HD T PointwiseVjp(T l1, T two_mse, const T& e) {
  return Select(e > T(0), l1, Select(e < T(0), -l1, T(0))) + two_mse * e;
}

// Converts a target image's byte to the range of a rendering: [0, 255] -> [0, 1].
COSPLAT_HD float FromByte(uint8_t byte) { return float(byte) * (1.0f / 255); }

// Composites a byte with straight alpha over a background in [0, 1].
COSPLAT_HD float Over(uint8_t value, uint8_t alpha_byte, float background) {
  const float alpha = FromByte(alpha_byte);
  return FromByte(value) * alpha + background * (1 - alpha);
}

COSPLAT_MATH_END
#endif

// A target image's bytes as the numbers that a rendering is compared with.
#if defined(COSPLAT_SPLAT_MATH_PHOTOGRAPH_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_PHOTOGRAPH_H_
#undef COSPLAT_SPLAT_MATH_PHOTOGRAPH_H_
#else
#define COSPLAT_SPLAT_MATH_PHOTOGRAPH_H_
#endif

#include <cstdint>

#include "splat/math/namespace.h"

COSPLAT_MATH_BEGIN

// [0, 255] -> [0, 1].
COSPLAT_HD float FromByte(uint8_t byte) { return float(byte) * (1.0f / 255); }

// A value of straight alpha over a background, bytes over [0, 1].
COSPLAT_HD float Over(uint8_t value, uint8_t alpha_byte, float background) {
  const float alpha = FromByte(alpha_byte);
  return FromByte(value) * alpha + background * (1 - alpha);
}

COSPLAT_MATH_END
#endif

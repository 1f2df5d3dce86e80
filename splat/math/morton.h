// The place of a point along a Morton curve: neighbours along it are near in space.
#if defined(COSPLAT_SPLAT_MATH_MORTON_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_MORTON_H_
#undef COSPLAT_SPLAT_MATH_MORTON_H_
#else
#define COSPLAT_SPLAT_MATH_MORTON_H_
#endif

#include <cmath>
#include <cstdint>

#include "splat/math/namespace.h"

COSPLAT_MATH_BEGIN

constexpr int kMortonBits = 21;  // per axis: three fit 64 bits

// Moves the lowest 21 bits to every third bit position.
COSPLAT_HD uint64_t SpreadBits(uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

COSPLAT_HD bool IsFinitePoint(const float* p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

// Position along a Morton curve through the box [low, high]; non-finite points come last.
COSPLAT_HD uint64_t MortonCode(const float* p, const float* low, const float* high) {
  if (!IsFinitePoint(p)) return ~uint64_t(0);
  uint64_t code = 0;
  for (int k = 0; k < 3; ++k) {
    // In double: the box may be wider than a float's range, and 2^21 cells need 21 bits.
    const double side = double(high[k]) - low[k];
    const double share = (double(p[k]) - low[k]) / (side > 1e-30 ? side : 1e-30);
    code |= SpreadBits(uint64_t(share * ((1 << kMortonBits) - 1))) << k;
  }
  return code;
}

COSPLAT_MATH_END
#endif

// Directions and coefficients that all ways to evaluate colour are given, and those ways.
// For apps/study/stability/basis_{forms,floats,packs}.cpp.
#pragma once

#include <cstdint>

namespace cosplat {

enum class BasisWay { kLiteral, kTextbook, kPolynomials };

// Coefficient c of function k of sample i: coefficients[(3 k + c) * kStride + i].
struct BasisSamples {
  // A multiple of every pack's lanes; directions and the coefficients of degree 6 fit a core's own
  // cache.
  static constexpr int kCount = 256;
  // An odd number of cache lines, lest all coefficients of a sample meet in a few sets of the
  // cache.
  static constexpr int kStride = kCount + 16;
  const float *x, *y, *z;
  const float* coefficients;
  const uint16_t* halves;  // the same, rounded to IEEE half precision
};

// out[kCount][c] for c = 0, 1, 2 at out[c * kCount + i]: the colour of each sample. On plain
// floats, one after the other; on packs; on packs with the coefficients read from `halves`.
void EvaluateOnFloats(BasisWay way, int degree, const BasisSamples& samples, float* out);
void EvaluateOnPacks(BasisWay way, int degree, const BasisSamples& samples, float* out);
void EvaluateFromHalves(int degree, const BasisSamples& samples, float* out);  // polynomials

// Rounded to the nearest half. 64-byte aligned, `count` a multiple of 16.
void RoundToHalves(const float* values, uint16_t* halves, int count);

}  // namespace cosplat

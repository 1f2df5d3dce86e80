// Directions and coefficients shared by all implementations of colour evaluation, and these
// implementations. For apps/study/stability/basis_{forms,floats,packs}.cpp.
#pragma once

#include <cstdint>

namespace cosplat {

enum class BasisWay { kLiteral, kTextbook, kPolynomials };

// Coefficient c of function k of sample i: coefficients[(3 k + c) * kStride + i].
struct BasisSamples {
  // A multiple of every pack's lane count; directions and coefficients of degree 6 fit a core's
  // private cache.
  static constexpr int kCount = 256;
  // An odd number of cache lines, to avoid cache set conflicts between the coefficients of a
  // sample.
  static constexpr int kStride = kCount + 16;
  const float *x, *y, *z;
  const float* coefficients;
  const uint16_t* halves;  // the same, rounded to IEEE half precision
};

// Writes the colour of each sample i to out[c * kCount + i], c = 0, 1, 2. On scalar floats, one
// sample at a time; on packs; on packs with the coefficients read from `halves`.
void EvaluateOnFloats(BasisWay way, int degree, const BasisSamples& samples, float* out);
void EvaluateOnPacks(BasisWay way, int degree, const BasisSamples& samples, float* out);
void EvaluateFromHalves(int degree, const BasisSamples& samples, float* out);  // polynomials

// Rounds to the nearest half. Pointers are 64-byte aligned, `count` is a multiple of 16.
void RoundToHalves(const float* values, uint16_t* halves, int count);

}  // namespace cosplat

// Cost and benefit of storing Adam's moments in 16 bits; the actual optimiser stores floats.
//
// A 16-bit number is the upper half of a float (bfloat16: a float's exponent, 8 significant bits).
// With rounding to nearest, a second moment would never shrink, since 1 - beta2 is less than half
// of its last bit; it is therefore rounded stochastically, unbiased in expectation (Gupta et al.
// 2015, Deep Learning with Limited Numerical Precision).
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

// Rounds elements [begin, end) of m and v to 16-bit precision. The random bits are a hash of an
// element's index and `step`. Infinities and NaN are preserved.
void RoundMoments(uint32_t step, uint32_t begin, uint32_t end, float* m, float* v);

// Parameters, their gradients and their moments, stored as float or in 16 bits (uint16_t); and the
// constants of a step (math/adam.h).
template <class Moment>
struct MomentArray {
  float beta1 = 0, beta2 = 0, step_size = 0, scaled_eps = 0;
  const float* gradient = nullptr;
  float* value = nullptr;
  Moment* m = nullptr;
  Moment* v = nullptr;
};

// The optimiser's inner loop on elements [begin, end): AdamUpdate and, for 16-bit moments,
// RoundMoments. Returns the number of non-finite gradients (treated as zero).
size_t AdamRange(const MomentArray<float>& array, uint32_t step, uint32_t begin, uint32_t end);
size_t AdamRange(const MomentArray<uint16_t>& array, uint32_t step, uint32_t begin, uint32_t end);

struct AdamLoopTimes {
  double float_ms = 0;
  double half_ms = 0;
};

// Times a step of each variant on the same number of parameters (at least 1), on all threads, with
// cold caches; the fastest of `batches` (at least 1).
AdamLoopTimes TimeAdamLoops(uint32_t numbers, int batches);

}  // namespace cosplat

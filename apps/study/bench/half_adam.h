// What storing Adam's moments in 16 bits would cost and gain; the optimiser stores floats.
//
// A number of 16 bits is the upper half of a float (bfloat16: a float's exponent, 8 significant
// bits). Rounded to the nearest, a second moment would never shrink, since 1 - beta2 is less than
// half of its last bit; so it is rounded up or down at random, right on average (Gupta et al. 2015,
// Deep Learning with Limited Numerical Precision).
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

// Rounds numbers begin .. end of m and v to what 16 bits hold. The chance is a hash of a number's
// index and of `step`. Infinities and NaN stay what they are.
void RoundMoments(uint32_t step, uint32_t begin, uint32_t end, float* m, float* v);

// Numbers, their gradients and their moments, stored as float or in 16 bits (uint16_t); and the
// constants of a step (math/adam.h).
template <class Moment>
struct MomentArray {
  float beta1 = 0, beta2 = 0, step_size = 0, scaled_eps = 0;
  const float* gradient = nullptr;
  float* value = nullptr;
  Moment* m = nullptr;
  Moment* v = nullptr;
};

// The optimiser's inner loop on numbers begin .. end: AdamUpdate, and where moments have 16 bits
// then RoundMoments. Returns how many gradients were not finite (and counted as zero).
size_t AdamRange(const MomentArray<float>& array, uint32_t step, uint32_t begin, uint32_t end);
size_t AdamRange(const MomentArray<uint16_t>& array, uint32_t step, uint32_t begin, uint32_t end);

struct AdamLoopTimes {
  double float_ms = 0;
  double half_ms = 0;
};

// A step of each on the same count of numbers (at least 1), all threads, arrays in no cache; the
// fastest of `batches` (at least 1).
AdamLoopTimes TimeAdamLoops(uint32_t numbers, int batches);

}  // namespace cosplat

// What blend shapes add to one number of a mesh (Li et al. 2017, eq. 3 and 4): coefficients times
// the directions' numbers there. The CPU runs over numbers (flame/directions.h), a device over
// directions (flame/kernels/pose.h); both add in this order.
#pragma once

#include "splat/math/namespace.h"

namespace cosplat::flame_math {

// Four directions at once: the sum is loaded and stored less often.
template <class T>
COSPLAT_HD T AddFourDirections(T sum, const T* coefficients, T d0, T d1, T d2, T d3) {
  const T* const c = coefficients;
  return sum + ((c[0] * d0 + c[1] * d1) + (c[2] * d2 + c[3] * d3));
}
// Those that four do not go into.
template <class T>
COSPLAT_HD T AddDirection(T sum, T coefficient, T d) {
  return sum + coefficient * d;
}

}  // namespace cosplat::flame_math

// The colour basis `dcsh` in long double: the truth that ways to evaluate it are measured against.
#pragma once

#include <array>

#include "splat/basis_constants.h"

namespace cosplat {

struct ExactDirection {
  long double x, y, z;  // unit
};

// From the polar angle (0: the pole z = 1) and the turn around z, rad.
ExactDirection DirectionAt(long double polar, long double turn);

// All functions up to kMaxEvaluatedDegree, in 3DGS's order.
using ExactBasis = std::array<long double, kMaxCoefficients>;
ExactBasis ExactBasisAt(const ExactDirection& direction);

}  // namespace cosplat

// Implementations of a Gaussian's colour: accuracy and time of each.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/basis_constants.h"

namespace cosplat {

struct BasisFormPoint {
  int degree = 0;
  double error = 0;  // largest over the colour channels, of [0, 1], against long double
  double ns = 0;     // per colour, on one core
};

struct BasisForm {
  std::string name;
  std::vector<BasisFormPoint> points;  // degrees 0 to 6
};

// The literal form, the textbook angles and our polynomials, on scalar floats and on SIMD packs,
// the latter also with half-precision coefficients. Errors are over directions on the whole sphere
// and increasingly close to its poles, with random coefficients. Times are the fastest of
// `batches`, or 0 without any.
std::vector<BasisForm> MeasureBasisForms(int batches);

// The colour basis `dcsh` in long double: the reference for the errors above.

struct ExactDirection {
  long double x, y, z;  // unit
};

// From the polar angle (0: the pole z = 1) and the azimuth around z, radians.
ExactDirection DirectionAt(long double polar, long double turn);

// All functions up to kMaxEvaluatedDegree, in 3DGS's order.
using ExactBasis = std::array<long double, kMaxCoefficients>;
ExactBasis ExactBasisAt(const ExactDirection& direction);

}  // namespace cosplat

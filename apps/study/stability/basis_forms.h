// Ways to evaluate a Gaussian's colour: how far each is from the truth, and how long it takes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "splat/basis_constants.h"

namespace cosplat {

struct BasisFormPoint {
  int degree = 0;
  double error = 0;  // largest of a colour's channels, of [0, 1], against long double
  double ns = 0;     // per colour, on one core
};

struct BasisForm {
  std::string name;
  std::vector<BasisFormPoint> points;  // of degrees 0 to 6
};

// The literal form, the textbook's angles and our polynomials, on plain floats and on packs, the
// last also with coefficients stored as halves. Errors are over directions all over the sphere and
// closer and closer to its poles, with random coefficients; times are the fastest of `batches`, 0
// with none.
std::vector<BasisForm> MeasureBasisForms(int batches);

// The colour basis `dcsh` in long double: the truth that ways to evaluate it are measured against.

struct ExactDirection {
  long double x, y, z;  // unit
};

// From the polar angle (0: the pole z = 1) and the turn around z, rad.
ExactDirection DirectionAt(long double polar, long double turn);

// All functions up to kMaxEvaluatedDegree, in 3DGS's order.
using ExactBasis = std::array<long double, kMaxCoefficients>;
ExactBasis ExactBasisAt(const ExactDirection& direction);

}  // namespace cosplat

// Normalisation constants of the colour bases, computed at compile time.
//   orthonormal K_l^m = sqrt((2l+1)/(4 pi) (l-m)!/(l+m)!), times sqrt2 for m != 0
//   sh:            K_l^m times 3DGS's sign (-1)^m
//   dcsh:          K_0 for l = 0; sqrt(4 pi) K_l^m for l >= 1 (N3D), no signs
//   dcsh-released: those of dcsh, except for kReleasedSlips
//   dcsh-literal:  K_l^m, no signs
#pragma once

#include <array>
#include <iterator>

#include "splat/basis.h"

namespace cosplat {

constexpr int kMaxEvaluatedDegree = 6;
constexpr int kMaxCoefficients = (kMaxEvaluatedDegree + 1) * (kMaxEvaluatedDegree + 1);

namespace internal {

constexpr double kPi = 3.14159265358979323846;

constexpr double ConstexprSqrt(double x) {
  double r = x > 1 ? x : 1;
  for (int i = 0; i < 100; ++i) r = 0.5 * (r + x / r);
  return r;
}

// Coefficients whose constants in DCSHARP's released code are not N3D's. There they multiply a
// differently scaled polynomial: our Q_l^m(z) {Re, Im} (x + iy)^m is `multiple` times it.
struct ReleasedSlip {
  int k;
  double constant, multiple;
};
constexpr ReleasedSlip kReleasedSlips[] = {
    {8, 1.1180340, 3},    // x^2 - y^2; N3D: sqrt(15)/2 = 1.9364917
    {10, 5.1234561, 30},  // xyz; N3D: sqrt(105) = 10.2469508
    {14, 5.1234561, 15},  // z (x^2 - y^2); N3D: sqrt(105)/2 = 5.1234754
};

constexpr std::array<float, kMaxCoefficients> MakeConstants(Basis basis) {
  std::array<float, kMaxCoefficients> k{};
  for (int l = 0; l <= kMaxEvaluatedDegree; ++l) {
    for (int m = 0; m <= l; ++m) {
      double ratio = 1;  // (l-m)! / (l+m)!
      for (int i = l - m + 1; i <= l + m; ++i) ratio /= i;
      double value = ConstexprSqrt((2 * l + 1) / (4 * kPi) * ratio * (m > 0 ? 2 : 1));
      const bool n3d = basis == Basis::kDcsh || basis == Basis::kDcshReleased;
      if (n3d && l > 0) value *= ConstexprSqrt(4 * kPi);
      if (basis == Basis::kSh && m % 2 == 1) value = -value;
      k[l * l + l + m] = float(value);
      k[l * l + l - m] = float(value);
    }
  }
  if (basis == Basis::kDcshReleased)
    for (const ReleasedSlip& slip : kReleasedSlips)
      k[slip.k] = float(slip.constant / slip.multiple);
  return k;
}

// In the order of Basis.
inline constexpr std::array<float, kMaxCoefficients> kConstants[] = {
    MakeConstants(Basis::kDcsh),
    MakeConstants(Basis::kSh),
    MakeConstants(Basis::kDcshReleased),
    MakeConstants(Basis::kDcshLiteral)};
static_assert(std::size(kConstants) == kBasisNames.size());

}  // namespace internal

// [49] in 3DGS's coefficient order.
inline const float* BasisConstants(Basis basis) {
  return internal::kConstants[size_t(basis)].data();
}

// The mean over all directions of the square of a channel's Laplacian on the unit sphere is the sum
// of these weights times the squares of its coefficients k: the penalty of smoothing splines (Wahba
// 1981, Spline interpolation and smoothing on the sphere). The Laplacian multiplies band l by
// -l (l + 1), and N3D's functions have a mean square of 1.
inline float CurvatureWeight(Basis basis, int k) {
  int l = 0;
  while (CoefficientCount(l) <= k) ++l;
  const float scale = BasisConstants(basis)[k] / BasisConstants(Basis::kDcsh)[k];
  return float(l * (l + 1) * l * (l + 1)) * scale * scale;
}

}  // namespace cosplat

// Normalisation constants of the two colour bases, computed, not typed.
//   orthonormal K_l^m = sqrt((2l+1)/(4 pi) (l-m)!/(l+m)!), times sqrt2 for m != 0
//   sh:   K_l^m times 3DGS's sign (-1)^m
//   dcsh: K_0 for l = 0; sqrt(4 pi) K_l^m for l >= 1 (N3D), no signs
#pragma once

#include <array>

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

constexpr std::array<float, kMaxCoefficients> MakeConstants(Basis basis) {
  std::array<float, kMaxCoefficients> k{};
  for (int l = 0; l <= kMaxEvaluatedDegree; ++l) {
    for (int m = 0; m <= l; ++m) {
      double ratio = 1;  // (l-m)! / (l+m)!
      for (int i = l - m + 1; i <= l + m; ++i) ratio /= i;
      double value = ConstexprSqrt((2 * l + 1) / (4 * kPi) * ratio * (m > 0 ? 2 : 1));
      if (basis == Basis::kDcsh && l > 0) value *= ConstexprSqrt(4 * kPi);
      if (basis == Basis::kSh && m % 2 == 1) value = -value;
      k[l * l + l + m] = float(value);
      k[l * l + l - m] = float(value);
    }
  }
  return k;
}

inline constexpr std::array<float, kMaxCoefficients> kDcshConstants = MakeConstants(Basis::kDcsh);
inline constexpr std::array<float, kMaxCoefficients> kShConstants = MakeConstants(Basis::kSh);

}  // namespace internal

// [49] in 3DGS's coefficient order.
inline const float* BasisConstants(Basis basis) {
  return basis == Basis::kDcsh ? internal::kDcshConstants.data() : internal::kShConstants.data();
}

}  // namespace cosplat

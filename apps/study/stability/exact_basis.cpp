#include <cmath>
#include <numbers>

#include "apps/study/stability/basis_forms.h"
#include "apps/study/stability/naive_basis.h"

namespace cosplat {
namespace {

// As BasisConstants(Basis::kDcsh), but not rounded to float.
ExactBasis ExactConstants() {
  ExactBasis constants;
  for (int l = 0; l <= kMaxEvaluatedDegree; ++l)
    for (int m = 0; m <= l; ++m) {
      long double square = (2 * l + 1) * (m > 0 ? 2 : 1);
      for (int i = l - m + 1; i <= l + m; ++i) square /= i;
      if (l == 0) square /= 4 * std::numbers::pi_v<long double>;
      constants[l * l + l + m] = constants[l * l + l - m] = std::sqrt(square);
    }
  return constants;
}

}  // namespace

ExactDirection DirectionAt(long double polar, long double turn) {
  const long double rho = std::sin(polar);
  return {rho * std::cos(turn), rho * std::sin(turn), std::cos(polar)};
}

ExactBasis ExactBasisAt(const ExactDirection& direction) {
  static const ExactBasis constants = ExactConstants();
  ExactBasis basis;
  const math::Vec3<long double> u{direction.x, direction.y, direction.z};
  math::BasisAtAngles<kMaxEvaluatedDegree>(math::ExactAngles(u), constants.data(), basis.data());
  return basis;
}

}  // namespace cosplat

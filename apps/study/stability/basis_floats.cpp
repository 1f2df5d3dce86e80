// EvaluateOnFloats, compiled without vectorisation: one sample at a time.
#include <utility>

#include "apps/study/stability/basis_samples.h"
#include "apps/study/stability/naive_basis.h"
#include "splat/basis_constants.h"
#include "splat/math/dcsh.h"

namespace cosplat {
namespace {

template <int kDegree>
math::Vec3<float> ColorAt(BasisWay way,
                          const math::Vec3<float>& u,
                          const float* dc,
                          const float* rest) {
  const float* constants = BasisConstants(Basis::kDcsh);
  if (way == BasisWay::kPolynomials)
    return math::EvaluateColor<kDegree, float>(u, constants, dc, rest);
  float basis[(kDegree + 1) * (kDegree + 1)];
  const bool literal = way == BasisWay::kLiteral;
  math::BasisAtAngles<kDegree>(
      literal ? math::LiteralAngles(u) : math::TextbookAngles(u), constants, basis);
  return math::ColorOfBasis<kDegree>(basis, dc, rest);
}

template <int kDegree>
void EvaluateAll(BasisWay way, const BasisSamples& samples, float* out) {
  constexpr int kNumbers = 3 * (kDegree + 1) * (kDegree + 1);
  for (int i = 0; i < BasisSamples::kCount; ++i) {
    float coefficients[kNumbers];
    for (int k = 0; k < kNumbers; ++k)
      coefficients[k] = samples.coefficients[k * BasisSamples::kStride + i];
    const math::Vec3<float> color = ColorAt<kDegree>(
        way, {samples.x[i], samples.y[i], samples.z[i]}, coefficients, coefficients + 3);
    out[i] = color.x;
    out[BasisSamples::kCount + i] = color.y;
    out[2 * BasisSamples::kCount + i] = color.z;
  }
}

}  // namespace

void EvaluateOnFloats(BasisWay way, int degree, const BasisSamples& samples, float* out) {
  [&]<int... kDegrees>(std::integer_sequence<int, kDegrees...>) {
    ((degree == kDegrees ? EvaluateAll<kDegrees>(way, samples, out) : void()), ...);
  }
  (std::make_integer_sequence<int, kMaxEvaluatedDegree + 1>{});
}

}  // namespace cosplat

// EvaluateOnPacks, EvaluateFromHalves and RoundToHalves, compiled per instruction set.
#include <utility>

#include "apps/study/stability/basis_samples.h"
#include "splat/basis_constants.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "apps/study/stability/basis_packs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "apps/study/stability/naive_basis.h"
#include "splat/math/dcsh.h"
#include "splat/render/cpu/pack.h"

COSPLAT_MATH_BEGIN

HWY_INLINE Pack Sin(const Pack& x) { return Pack(hn::Sin(Lanes(), x.v)); }
HWY_INLINE Pack Cos(const Pack& x) { return Pack(hn::Cos(Lanes(), x.v)); }
HWY_INLINE Pack Acos(const Pack& x) { return Pack(hn::Acos(Lanes(), x.v)); }
HWY_INLINE Pack Atan(const Pack& x) { return Pack(hn::Atan(Lanes(), x.v)); }
HWY_INLINE Pack Atan2(const Pack& y, const Pack& x) {
  constexpr float kPi = 3.14159265f;
  const Pack half_plane = Atan(y / x);
  const Pack turn = Select(y < Pack(0), Pack(-kPi), Pack(kPi));
  return Select(x < Pack(0), half_plane + turn, half_plane);
}
HWY_INLINE Pack SquareRoot(const Pack& x) { return Sqrt(x); }

using Halves = hn::Rebind<hwy::float16_t, Lanes>;
HWY_INLINE Pack LoadNumber(const float* at) { return LoadPack(at); }
HWY_INLINE Pack LoadNumber(const uint16_t* at) {
  const auto halves = hn::LoadU(Halves(), reinterpret_cast<const hwy::float16_t*>(at));
  return Pack(hn::PromoteTo(Lanes(), halves));
}

template <int kDegree>
HWY_INLINE Vec3<Pack> PackColorAt(BasisWay way,
                                  const Vec3<Pack>& u,
                                  const Pack* dc,
                                  const Pack* rest) {
  const float* constants = BasisConstants(Basis::kDcsh);
  if (way == BasisWay::kPolynomials) return EvaluateColor<kDegree, Pack>(u, constants, dc, rest);
  Pack basis[(kDegree + 1) * (kDegree + 1)];
  if (way == BasisWay::kLiteral)
    BasisAtAngles<kDegree>(LiteralAngles(u), constants, basis);
  else
    BasisAtAngles<kDegree>(TextbookAngles(u), constants, basis);
  return ColorOfBasis<kDegree>(basis, dc, rest);
}

template <int kDegree, class Number>
void EvaluatePacks(BasisWay way, const BasisSamples& s, const Number* numbers, float* out) {
  constexpr int kNumbers = 3 * (kDegree + 1) * (kDegree + 1);
  for (size_t i = 0; i < size_t(BasisSamples::kCount); i += kLanes) {
    Pack coefficients[kNumbers];
    for (int k = 0; k < kNumbers; ++k)
      coefficients[k] = LoadNumber(numbers + k * BasisSamples::kStride + i);
    const Vec3<Pack> u{LoadPack(s.x + i), LoadPack(s.y + i), LoadPack(s.z + i)};
    const Vec3<Pack> color = PackColorAt<kDegree>(way, u, coefficients, coefficients + 3);
    StorePack(color.x, out + i);
    StorePack(color.y, out + BasisSamples::kCount + i);
    StorePack(color.z, out + 2 * BasisSamples::kCount + i);
  }
}

template <class Number, int... kDegrees>
void EvaluateDegree(std::integer_sequence<int, kDegrees...>,
                    BasisWay way,
                    int degree,
                    const BasisSamples& s,
                    const Number* numbers,
                    float* out) {
  ((degree == kDegrees ? EvaluatePacks<kDegrees>(way, s, numbers, out) : void()), ...);
}
using AllDegrees = std::make_integer_sequence<int, kMaxEvaluatedDegree + 1>;

void PacksFromFloats(BasisWay way, int degree, const BasisSamples& samples, float* out) {
  EvaluateDegree(AllDegrees(), way, degree, samples, samples.coefficients, out);
}
void PacksFromHalves(BasisWay way, int degree, const BasisSamples& samples, float* out) {
  EvaluateDegree(AllDegrees(), way, degree, samples, samples.halves, out);
}

void PacksToHalves(const float* values, uint16_t* halves, int count) {
  for (size_t i = 0; i < size_t(count); i += kLanes)
    hn::StoreU(hn::DemoteTo(Halves(), LoadPack(values + i).v),
               Halves(),
               reinterpret_cast<hwy::float16_t*>(halves + i));
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(PacksFromFloats);
HWY_EXPORT(PacksFromHalves);
HWY_EXPORT(PacksToHalves);
}  // namespace math

void EvaluateOnPacks(BasisWay way, int degree, const BasisSamples& samples, float* out) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(PacksFromFloats)(way, degree, samples, out);
}

void EvaluateFromHalves(int degree, const BasisSamples& samples, float* out) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(PacksFromHalves)(BasisWay::kPolynomials, degree, samples, out);
}

void RoundToHalves(const float* values, uint16_t* halves, int count) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(PacksToHalves)(values, halves, count);
}

}  // namespace cosplat
#endif

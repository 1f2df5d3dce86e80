// A SIMD register as a scalar type: the formulas of splat/math run on it unchanged.
// Re-included per Highway target; at most kTileSize lanes (one row of a tile).
#if defined(COSPLAT_SPLAT_CPU_PACK_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_CPU_PACK_H_
#undef COSPLAT_SPLAT_CPU_PACK_H_
#else
#define COSPLAT_SPLAT_CPU_PACK_H_
#endif

#include <hwy/highway.h>

#include "splat/config.h"
#include "splat/math/scalar.h"

COSPLAT_MATH_BEGIN

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<float, kTileSize>;
constexpr size_t kLanes = hn::MaxLanes(Lanes());

struct PackMask {
  hn::Mask<Lanes> m;
};

struct Pack {
  hn::Vec<Lanes> v;
  Pack() = default;
  explicit Pack(float s) : v(hn::Set(Lanes(), s)) {}
  explicit Pack(hn::Vec<Lanes> v) : v(v) {}
};

HWY_INLINE Pack LoadPack(const float* aligned) { return Pack(hn::Load(Lanes(), aligned)); }
HWY_INLINE void StorePack(const Pack& a, float* aligned) { hn::Store(a.v, Lanes(), aligned); }
// first, first + 1, first + 2, ...
HWY_INLINE Pack Ramp(float first) { return Pack(hn::Iota(Lanes(), first)); }
HWY_INLINE float Sum(const Pack& a) { return hn::GetLane(hn::SumOfLanes(Lanes(), a.v)); }
HWY_INLINE bool AnyTrue(const PackMask& m) { return !hn::AllFalse(Lanes(), m.m); }

HWY_INLINE Pack operator+(const Pack& a, const Pack& b) { return Pack(hn::Add(a.v, b.v)); }
HWY_INLINE Pack operator-(const Pack& a, const Pack& b) { return Pack(hn::Sub(a.v, b.v)); }
HWY_INLINE Pack operator*(const Pack& a, const Pack& b) { return Pack(hn::Mul(a.v, b.v)); }
HWY_INLINE Pack operator/(const Pack& a, const Pack& b) { return Pack(hn::Div(a.v, b.v)); }
HWY_INLINE Pack operator-(const Pack& a) { return Pack(hn::Neg(a.v)); }
HWY_INLINE Pack& operator+=(Pack& a, const Pack& b) { return a = a + b; }
HWY_INLINE PackMask operator<(const Pack& a, const Pack& b) { return {hn::Lt(a.v, b.v)}; }
HWY_INLINE PackMask operator>(const Pack& a, const Pack& b) { return {hn::Gt(a.v, b.v)}; }
HWY_INLINE PackMask operator>=(const Pack& a, const Pack& b) { return {hn::Ge(a.v, b.v)}; }
HWY_INLINE PackMask And(const PackMask& a, const PackMask& b) { return {hn::And(a.m, b.m)}; }
HWY_INLINE Pack Select(const PackMask& m, const Pack& a, const Pack& b) {
  return Pack(hn::IfThenElse(m.m, a.v, b.v));
}
HWY_INLINE Pack Min(const Pack& a, const Pack& b) { return Pack(hn::Min(a.v, b.v)); }
HWY_INLINE Pack Max(const Pack& a, const Pack& b) { return Pack(hn::Max(a.v, b.v)); }

// e^x for x in [-87, 88], clamped below: 2^n times the Taylor polynomial of 2^f, |f| <= 1/2, whose
// coefficients are ln(2)^k / k!. Relative error < 6e-7 on [-5.6, 0], which is all that the blend
// loop accepts, and < 5e-6 anywhere (tests/splat/pack_test.cpp).
HWY_INLINE Pack Exp(const Pack& x) {
  const Lanes d;
  const hn::RebindToSigned<Lanes> di;
  const auto t = hn::Mul(hn::Max(x.v, hn::Set(d, -87.0f)), hn::Set(d, 1.44269504f));
  const auto n = hn::Round(t);
  const auto f = hn::Sub(t, n);
  auto p = hn::Set(d, 1.54035304e-4f);
  p = hn::MulAdd(p, f, hn::Set(d, 1.33335581e-3f));
  p = hn::MulAdd(p, f, hn::Set(d, 9.61812911e-3f));
  p = hn::MulAdd(p, f, hn::Set(d, 5.55041087e-2f));
  p = hn::MulAdd(p, f, hn::Set(d, 2.40226507e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 6.93147181e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 1.0f));
  const auto exponent = hn::ShiftLeft<23>(hn::ConvertTo(di, n));
  return Pack(hn::BitCast(d, hn::Add(hn::BitCast(di, p), exponent)));
}

COSPLAT_MATH_END
#endif

// A SIMD register that behaves like a scalar type, so that the formulas in splat/math/ run on it
// unchanged. Re-included once per Highway target; has at most kTileSize lanes (one 4x4 block of a
// tile's pixels).
#if defined(COSPLAT_SPLAT_CPU_PACK_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_CPU_PACK_H_
#undef COSPLAT_SPLAT_CPU_PACK_H_
#else
#define COSPLAT_SPLAT_CPU_PACK_H_
#endif

#include <hwy/contrib/math/math-inl.h>
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

// Bit l corresponds to lane l.
HWY_INLINE uint32_t MaskBits(const PackMask& m) {
#if HWY_TARGET == HWY_WASM
  return wasm_i32x4_bitmask(m.m.raw);  // StoreMaskBits goes through memory
#else
  uint8_t bytes[8] = {};  // StoreMaskBits needs at least 8 writable bytes
  hn::StoreMaskBits(Lanes(), m.m, bytes);
  return uint32_t(bytes[0]) | uint32_t(bytes[1]) << 8;
#endif
}

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

HWY_INLINE Pack Sqrt(const Pack& x) { return Pack(hn::Sqrt(x.v)); }
HWY_INLINE Pack Abs(const Pack& x) { return Pack(hn::Abs(x.v)); }
// Highway's Exp is valid up to x = 104, where e^x is already infinite in float; above that, and for
// NaN, its result is unspecified, hence the clamp and the select.
HWY_INLINE Pack Exp(const Pack& x) {
  const Lanes d;
  const auto e = hn::Exp(d, hn::Min(x.v, hn::Set(d, 104.0f)));
  return Pack(hn::IfThenElse(hn::Eq(x.v, x.v), e, x.v));
}
HWY_INLINE Pack Log(const Pack& x) { return Pack(hn::Log(Lanes(), x.v)); }

// Coefficients, lowest order first, of the polynomials for 2^f, |f| <= 1/2, with the smallest
// relative error for their degree (Remez algorithm). Relative errors of degrees 2 to 5: 1.7e-3,
// 7.5e-5, 2.6e-6 and 7.5e-8, which is float precision.
constexpr float kExp2Coefficients[6][6] = {
    {},
    {},
    {1.000443142f, 0.7034480060f, 0.2384289355f},
    {0.9999280736f, 0.6932609847f, 0.2426111224f, 5.517167233e-2f},
    {0.9999992614f, 0.6931218147f, 0.2402474483f, 5.591786034e-2f, 9.570101863e-3f},
    {1.000000072f, 0.6931469671f, 0.2402211972f, 5.550713272e-2f, 9.675541343e-3f, 1.327647263e-3f},
};

// e^x for x in [-80, 0]; unspecified below. Computed as 2^n times the polynomial for 2^f; adding
// 1.5 * 2^23 rounds to an integer and leaves it in the lowest bits.
template <int kDegree>
HWY_INLINE Pack FastExp(const Pack& x) {
  static_assert(kDegree >= kMinExpDegree && kDegree <= kMaxExpDegree);
  const Lanes d;
  const hn::RebindToSigned<Lanes> di;
  const auto log2_e = hn::Set(d, 1.44269504f), shift = hn::Set(d, 12582912.0f);
  const auto shifted = hn::MulAdd(x.v, log2_e, shift);
  const auto f = hn::MulSub(x.v, log2_e, hn::Sub(shifted, shift));
  auto p = hn::Set(d, kExp2Coefficients[kDegree][kDegree]);
  for (int k = kDegree - 1; k >= 0; --k)
    p = hn::MulAdd(p, f, hn::Set(d, kExp2Coefficients[kDegree][k]));
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(di, shifted));
  return Pack(hn::BitCast(d, hn::Add(hn::BitCast(di, p), exponent)));
}

#if HWY_TARGET != HWY_SCALAR
// Transposes the 4x4 matrices formed by corresponding 128-bit blocks of the four vectors.
template <class D>
HWY_INLINE void Transpose4x4(D d, hn::Vec<D>& v0, hn::Vec<D>& v1, hn::Vec<D>& v2, hn::Vec<D>& v3) {
  const hn::RepartitionToWide<D> wide;
  const auto low_01 = hn::BitCast(wide, hn::InterleaveLower(d, v0, v1));
  const auto high_01 = hn::BitCast(wide, hn::InterleaveUpper(d, v0, v1));
  const auto low_23 = hn::BitCast(wide, hn::InterleaveLower(d, v2, v3));
  const auto high_23 = hn::BitCast(wide, hn::InterleaveUpper(d, v2, v3));
  v0 = hn::BitCast(d, hn::InterleaveLower(wide, low_01, low_23));
  v1 = hn::BitCast(d, hn::InterleaveUpper(wide, low_01, low_23));
  v2 = hn::BitCast(d, hn::InterleaveLower(wide, high_01, high_23));
  v3 = hn::BitCast(d, hn::InterleaveUpper(wide, high_01, high_23));
}

// sums[i] is the sum of the lanes of v[i]. Reducing eight vectors together takes fewer instructions
// than reducing them one by one.
template <class D>
HWY_INLINE void SumEight(D d, const hn::Vec<D>* v, float* sums) {
  if constexpr (hn::MaxLanes(D()) == 16) {
    const hn::Half<D> half;
    hn::Vec<hn::Half<D>> h[8];
    for (int i = 0; i < 8; ++i)
      h[i] = hn::Add(hn::LowerHalf(half, v[i]), hn::UpperHalf(half, v[i]));
    SumEight(half, h, sums);
  } else if constexpr (hn::MaxLanes(D()) == 8) {
    hn::Vec<D> w[4];  // partial sums of v[i] in the lower half, of v[i + 4] in the upper
    for (int i = 0; i < 4; ++i)
      w[i] =
          hn::Add(hn::ConcatLowerLower(d, v[i + 4], v[i]), hn::ConcatUpperUpper(d, v[i + 4], v[i]));
    Transpose4x4(d, w[0], w[1], w[2], w[3]);
    hn::StoreU(hn::Add(hn::Add(w[0], w[1]), hn::Add(w[2], w[3])), d, sums);
  } else {
    for (int i = 0; i < 8; i += 4) {
      hn::Vec<D> w[4] = {v[i], v[i + 1], v[i + 2], v[i + 3]};
      Transpose4x4(d, w[0], w[1], w[2], w[3]);
      hn::StoreU(hn::Add(hn::Add(w[0], w[1]), hn::Add(w[2], w[3])), d, sums + i);
    }
  }
}
#endif

// sums[i] = Sum(p[i]).
template <int kCount>
HWY_INLINE void SumEach(const Pack* p, float* sums) {
  int i = 0;
#if HWY_TARGET != HWY_SCALAR
  for (; i + 8 <= kCount; i += 8) {
    const hn::Vec<Lanes> v[8] = {
        p[i].v, p[i + 1].v, p[i + 2].v, p[i + 3].v, p[i + 4].v, p[i + 5].v, p[i + 6].v, p[i + 7].v};
    SumEight(Lanes(), v, sums + i);
  }
#endif
  for (; i < kCount; ++i) sums[i] = Sum(p[i]);
}

COSPLAT_MATH_END
#endif

// The SIMD register as a scalar type (splat/render/cpu/pack.h), on every instruction set of this
// machine.
#include <algorithm>
#include <cmath>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/splat/pack_test.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/render/cpu/pack_rows.h"

COSPLAT_MATH_BEGIN

// Largest relative error of f on `steps` even steps of [from, to].
template <class F>
double LargestError(const F& f, double from, double to, int steps) {
  alignas(64) float x[kTileSize], y[kTileSize];
  const int lanes = int(kLanes);
  double largest = 0;
  for (int i = 0; i < steps; i += lanes) {
    for (int k = 0; k < lanes; ++k)
      x[k] = float(from + (to - from) * std::min(i + k, steps) / steps);
    StorePack(f(LoadPack(x)), y);
    for (int k = 0; k < lanes; ++k) {
      const double exact = std::exp(double(x[k]));
      largest = std::max(largest, std::abs(y[k] - exact) / exact);
    }
  }
  return largest;
}
double LargestExpError(double from, double to, int steps) {
  return LargestError([](const Pack& x) HWY_ATTR { return Exp(x); }, from, to, steps);
}
double LargestFastExpError(int degree, double from, double to, int steps) {
  const auto error = [&](const auto& f) { return LargestError(f, from, to, steps); };
  switch (degree) {
    case 2:
      return error([](const Pack& x) HWY_ATTR { return FastExp<2>(x); });
    case 3:
      return error([](const Pack& x) HWY_ATTR { return FastExp<3>(x); });
    case 4:
      return error([](const Pack& x) HWY_ATTR { return FastExp<4>(x); });
    default:
      return error([](const Pack& x) HWY_ATTR { return FastExp<5>(x); });
  }
}

float ExpOf(float x) {
  alignas(64) float y[kTileSize];
  StorePack(Exp(Pack(x)), y);
  return y[kLanes - 1];
}

// Rows of an array through packs into another array, `kUsed` numbers of each; the rest stays.
template <int kUsed>
void CopyRows(size_t count, size_t width, const float* from, float* to) {
  for (size_t i = 0; i < count; i += kLanes) {
    const Rows rows{i, std::min(kLanes, count - i)};
    Pack numbers[kUsed];
    LoadRows<kUsed>(from, width, rows, numbers);
    alignas(64) float lane[kTileSize];
    for (size_t l = 0; l < rows.count; ++l)
      for (int k = 0; k < kUsed; ++k) {
        StorePack(numbers[k], lane);
        if (lane[l] != from[width * (i + l) + k]) return;  // leaves the copy unfinished
      }
    StoreRows<kUsed>(numbers, to, width, rows);
  }
}
void CopyUsed(int used, size_t count, size_t width, const float* from, float* to) {
  switch (used) {
    case 1:
      return CopyRows<1>(count, width, from, to);
    case 2:
      return CopyRows<2>(count, width, from, to);
    case 3:
      return CopyRows<3>(count, width, from, to);
    case 4:
      return CopyRows<4>(count, width, from, to);
    case 9:
      return CopyRows<9>(count, width, from, to);
    default:
      return CopyRows<45>(count, width, from, to);
  }
}

// For each pair: min, max, the smaller by Select, and the three comparisons as 1 or 0.
void CompareLanes(const float* a, const float* b, float (*out)[6]) {
  alignas(64) float lane[6][kTileSize];
  const Pack x(*a), y(*b), one(1.0f), zero(0.0f);
  StorePack(Min(x, y), lane[0]);
  StorePack(Max(x, y), lane[1]);
  StorePack(Select(x < y, x, y), lane[2]);
  StorePack(Select(x < y, one, zero), lane[3]);
  StorePack(Select(x > y, one, zero), lane[4]);
  StorePack(Select(And(x >= y, y >= zero), one, zero), lane[5]);
  for (int k = 0; k < 6; ++k) (*out)[k] = lane[k][0];
}

// Lanes of Select, Ramp, Sum and AnyTrue; returns how many are wrong.
int WrongLanes() {
  alignas(64) float y[kTileSize];
  const int lanes = int(kLanes);
  int wrong = 0;
  const Pack ramp = Ramp(3.5f);
  StorePack(Select(ramp < Pack(4.0f), Pack(-1.0f), ramp), y);
  for (int k = 0; k < lanes; ++k) wrong += y[k] != (k == 0 ? -1.0f : 3.5f + float(k));
  wrong += Sum(ramp) != float(lanes) * (3.5f + 0.5f * float(lanes - 1));
  wrong += AnyTrue(ramp < Pack(3.0f));
  wrong += !AnyTrue(ramp > Pack(3.0f + float(lanes - 1)));  // the last lane alone
  wrong += AnyTrue(And(ramp<Pack(100.0f), ramp> Pack(100.0f)));
  wrong += kTileSize % lanes;
  return wrong;
}

COSPLAT_MATH_END

#if HWY_ONCE
#include <gtest/gtest.h>

namespace cosplat {
namespace math {
HWY_EXPORT(LargestExpError);
HWY_EXPORT(LargestFastExpError);
HWY_EXPORT(ExpOf);
HWY_EXPORT(CopyUsed);
HWY_EXPORT(CompareLanes);
HWY_EXPORT(WrongLanes);
}  // namespace math

namespace {
using namespace math;

// Calls f once per instruction set, which the functions above then use.
template <class F>
void OnEveryTarget(const F& f) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    f();
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Pack, ExpIsAccurate) {
  OnEveryTarget([] {
    const auto error = HWY_DYNAMIC_DISPATCH(LargestExpError);
    EXPECT_LT(error(-87, 0, 800000), 1.5e-7);
    EXPECT_LT(error(0, 88, 800000), 2e-7);
  });
}

TEST(Pack, ExpOfLargeNumbersIsInfiniteAndOfSmallOnesZero) {
  OnEveryTarget([] {
    const auto exp_of = HWY_DYNAMIC_DISPATCH(ExpOf);
    EXPECT_EQ(exp_of(0), 1);
    for (const float x : {89.0f, 105.0f, 179.0f, 200.0f, 355.0f, 1000.0f, 1e30f, INFINITY}) {
      EXPECT_EQ(exp_of(x), INFINITY) << x;
      EXPECT_EQ(exp_of(-2 * x), 0) << x;
    }
    EXPECT_TRUE(std::isnan(exp_of(NAN)));
  });
}

TEST(Pack, FastExpIsAccurateWhereItIsUsed) {
  OnEveryTarget([] {
    const auto error = HWY_DYNAMIC_DISPATCH(LargestFastExpError);
    // What the blend loop accepts: opacity <= 1, alpha >= 1/255. Measured: 2.9e-7 (5.6e-7 where
    // there is no FMA).
    EXPECT_LT(error(5, -5.6, 0, 800000), 6e-7);
    // x log2(e) has 24 bits, of which |x| takes up to 7. Measured: 1.3e-6 (3.9e-6).
    EXPECT_LT(error(5, -80, 0, 800000), 5e-6);
    // Lower degrees reach what the theory gives them.
    EXPECT_LT(error(4, -5.6, 0, 800000), 3.1e-6);
    EXPECT_LT(error(3, -5.6, 0, 800000), 7.6e-5);
    EXPECT_LT(error(2, -5.6, 0, 800000), 1.75e-3);
  });
}

TEST(Pack, RowsGoInAndComeBack) {
  OnEveryTarget([] {
    for (const auto& [used, width] :
         {std::pair{1, 1}, {2, 2}, {3, 3}, {4, 4}, {9, 9}, {9, 16}, {45, 45}, {3, 5}})
      for (const size_t count : {1, 5, 8, 16, 37}) {
        std::vector<float> from(count * width), to(count * width, -1.0f);
        for (size_t i = 0; i < from.size(); ++i) from[i] = float(i);
        HWY_DYNAMIC_DISPATCH(CopyUsed)(used, count, width, from.data(), to.data());
        for (size_t i = 0; i < from.size(); ++i)
          ASSERT_EQ(to[i], int(i) % width < used ? from[i] : -1.0f)
              << used << " of " << width << ", " << count << " rows, " << i;
      }
  });
}

TEST(Pack, ComparesAsScalarsDo) {
  const std::vector<float> values{-INFINITY, -2, -0.5f, 0, 1e-30f, 0.5f, 3, INFINITY};
  OnEveryTarget([&] {
    for (const float a : values)
      for (const float b : values) {
        float out[6];
        HWY_DYNAMIC_DISPATCH(CompareLanes)(&a, &b, &out);
        EXPECT_EQ(out[0], std::min(a, b));
        EXPECT_EQ(out[1], std::max(a, b));
        EXPECT_EQ(out[2], std::min(a, b));
        EXPECT_EQ(out[3], a < b);
        EXPECT_EQ(out[4], a > b);
        EXPECT_EQ(out[5], a >= b && b >= 0);
      }
  });
}

TEST(Pack, ComparisonsWithNanAreFalse) {
  // A splat whose exponent is not a number is not blended.
  OnEveryTarget([] {
    const float nan = NAN, one = 1;
    float out[6];
    for (const auto& [a, b] : {std::pair{nan, one}, {one, nan}, {nan, nan}}) {
      HWY_DYNAMIC_DISPATCH(CompareLanes)(&a, &b, &out);
      for (int k = 3; k < 6; ++k) EXPECT_EQ(out[k], 0);
    }
  });
}

TEST(Pack, EveryLane) {
  OnEveryTarget([] { EXPECT_EQ(HWY_DYNAMIC_DISPATCH(WrongLanes)(), 0); });
}

}  // namespace
}  // namespace cosplat
#endif

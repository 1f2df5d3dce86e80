// The SIMD register as a scalar type (splat/cpu/pack.h), on every instruction set of this machine.
#include <algorithm>
#include <cmath>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/splat/pack_test.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/cpu/pack.h"

COSPLAT_MATH_BEGIN

// Largest relative error of Exp on `steps` even steps of [from, to].
double LargestExpError(double from, double to, int steps) {
  alignas(64) float x[kTileSize], y[kTileSize];
  const int lanes = int(kLanes);
  double largest = 0;
  for (int i = 0; i < steps; i += lanes) {
    for (int k = 0; k < lanes; ++k)
      x[k] = float(from + (to - from) * std::min(i + k, steps) / steps);
    StorePack(Exp(LoadPack(x)), y);
    for (int k = 0; k < lanes; ++k) {
      const double exact = std::exp(double(x[k]));
      largest = std::max(largest, std::abs(y[k] - exact) / exact);
    }
  }
  return largest;
}

float ExpOf(float x) {
  alignas(64) float y[kTileSize];
  StorePack(Exp(Pack(x)), y);
  return y[kLanes - 1];
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
HWY_EXPORT(ExpOf);
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
    // What the blend loop accepts: opacity <= 1, alpha >= 1/255. Measured 4.5e-7.
    EXPECT_LT(error(-5.6, 0, 800000), 6e-7);
    // x log2(e) has 24 bits, of which |x| takes up to 7. Measured 4.0e-6.
    EXPECT_LT(error(-87, 0, 800000), 5e-6);
    EXPECT_LT(error(0, 88, 800000), 5e-6);
  });
}

TEST(Pack, ExpAtItsEnds) {
  OnEveryTarget([] {
    EXPECT_EQ(HWY_DYNAMIC_DISPATCH(ExpOf)(0), 1);
    const float lowest = HWY_DYNAMIC_DISPATCH(ExpOf)(-87);
    EXPECT_GT(lowest, 0);
    EXPECT_EQ(HWY_DYNAMIC_DISPATCH(ExpOf)(-1000), lowest);  // clamped
    EXPECT_EQ(HWY_DYNAMIC_DISPATCH(ExpOf)(-INFINITY), lowest);
    EXPECT_TRUE(std::isfinite(HWY_DYNAMIC_DISPATCH(ExpOf)(88)));
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

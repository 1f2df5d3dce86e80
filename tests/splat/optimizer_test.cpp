// Adam over all attributes: against a plain double Adam, and with gradients that are not numbers.
#include "splat/train/optimize/optimizer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/math/adam.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

AdamSettings Rates() {
  AdamSettings settings;
  settings.rate = {1e-3f, 2e-3f, 5e-3f, 5e-2f, 2.5e-3f, 1.25e-4f};
  return settings;
}

std::vector<uint32_t> AllGroups(size_t n) {
  std::vector<uint32_t> groups(AdamGroupCount(n));
  std::iota(groups.begin(), groups.end(), 0u);
  return groups;
}

// A step on these groups alone. Returns how many gradients were not finite.
size_t StepOf(const AdamSettings& settings,
              const Gaussians& gradients,
              View<const float> rate_scale,
              const std::vector<uint32_t>& groups,
              Gaussians& values,
              AdamState& state) {
  Buffer<float> moves(values.size(), 0.0f);
  for (const uint32_t g : groups) moves[g * kGaussianGroup] = 1;
  const uint32_t before = state.ignored[0];
  AdamStepAll(settings, gradients, rate_scale, moves, values, state);
  return state.ignored[0] - before;
}

Gaussians Gradients(size_t n, uint64_t seed) {
  return test::RandomGaussians(n, 1, Basis::kDcsh, seed);
}

// Kingma & Ba 2015, algorithm 1, as it stands there. In double, with the betas that a float holds.
struct PlainAdam {
  double value = 0, m = 0, v = 0;
  void Step(double gradient, double rate, double eps, int t) {
    const double beta1 = 0.9f, beta2 = 0.999f;
    m = beta1 * m + (1 - beta1) * gradient;
    v = beta2 * v + (1 - beta2) * gradient * gradient;
    value -=
        rate * (m / (1 - std::pow(beta1, t))) / (std::sqrt(v / (1 - std::pow(beta2, t))) + eps);
  }
};

TEST(Adam, EqualsThePlainOne) {
  const size_t n = 9;
  Gaussians g = Gradients(n, 1);
  AdamState state = AdamState(g);
  AdamSettings settings = Rates();
  settings.eps[kColorRest] = 0.1f;  // one that matters
  std::array<std::vector<PlainAdam>, kAttributeCount> plain;
  for (int a = 0; a < kAttributeCount; ++a)
    for (const float v : g.values[a]) plain[a].push_back({v});
  const Gaussians start = g;
  for (int t = 1; t <= 300; ++t) {
    const Gaussians d = Gradients(n, 100 + t);
    EXPECT_EQ(StepOf(settings, d, {}, AllGroups(n), g, state), 0u);
    EXPECT_EQ(state.step, t);
    for (int a = 0; a < kAttributeCount; ++a)
      for (size_t i = 0; i < plain[a].size(); ++i)
        plain[a][i].Step(d.values[a][i], settings.rate[a], settings.eps[a], t);
  }
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < plain[a].size(); ++i) {
      EXPECT_NE(g.values[a][i], start.values[a][i]);
      // 300 steps of float rounding; 1 - 0.999 as a float is 1e-5 off, as in every float Adam.
      EXPECT_NEAR(g.values[a][i], plain[a][i].value, 1e-5 + 1e-3 * settings.rate[a]) << a;
    }
}

TEST(Adam, BrokenGradientsCountAndChangeNothingElse) {
  Gaussians g = Gradients(7, 2), clean = g;
  AdamState state = AdamState(g), clean_state = state;
  Gaussians d = Gradients(7, 3), clean_d = d;
  const std::vector<float> poison{NAN, INFINITY, -INFINITY, 3e38f};  // the last one's square
  for (size_t i = 0; i < poison.size(); ++i) {
    d.values[kScaleLog][i] = poison[i];
    clean_d.values[kScaleLog][i] = 0;
  }
  d.values[kColorRest][5] = NAN;
  clean_d.values[kColorRest][5] = 0;
  EXPECT_EQ(StepOf(Rates(), d, {}, AllGroups(7), g, state), 5u);
  EXPECT_EQ(StepOf(Rates(), clean_d, {}, AllGroups(7), clean, clean_state), 0u);
  for (int a = 0; a < kAttributeCount; ++a) {
    for (const float v : g.values[a]) EXPECT_TRUE(std::isfinite(v));
    EXPECT_EQ(g.values[a], clean.values[a]);
    EXPECT_EQ(state.m.values[a], clean_state.m.values[a]);
    EXPECT_EQ(state.v.values[a], clean_state.v.values[a]);
  }
}

TEST(Adam, ZeroGradientsMoveNothing) {
  Gaussians g = Gradients(3, 4);
  const Gaussians before = g;
  AdamState state = AdamState(g);
  StepOf(Rates(), g.ZerosLike(), {}, AllGroups(3), g, state);
  for (int a = 0; a < kAttributeCount; ++a) EXPECT_EQ(g.values[a], before.values[a]);
}

TEST(Adam, PositionRateScaleMultipliesThePositionsStepAlone) {
  const Gaussians start = Gradients(5, 5), d = Gradients(5, 6);
  Gaussians plain = start, scaled = start;
  AdamState plain_state = AdamState(start), scaled_state = plain_state;
  Buffer<float> scale(15);
  for (size_t i = 0; i < scale.size(); ++i) scale[i] = float(i) - 4;  // 0 and negatives too
  StepOf(Rates(), d, {}, AllGroups(5), plain, plain_state);
  StepOf(Rates(), d, scale, AllGroups(5), scaled, scaled_state);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t i = 0; i < start.values[a].size(); ++i) {
      const float step = plain.values[a][i] - start.values[a][i];
      const float factor = a == kPosition ? scale[i] : 1.0f;
      EXPECT_NEAR(scaled.values[a][i] - start.values[a][i], factor * step, 2e-6) << a;
    }
}

TEST(Adam, WhatIsPutOffIsMadeUpFor) {
  // Groups that get gradients now and then, against all of them in every step (zero gradients
  // meanwhile). What differs is the step size, which changes while a group waits: most at the
  // start.
  const size_t n = 70;
  for (const int start : {0, 1000}) {
    Gaussians all = Gradients(n, 9), some = all;
    AdamState all_state(all), some_state(all);
    all_state.step = some_state.step = start;
    some_state.updated.assign(some_state.updated.size(), start);
    const Gaussians first = all;
    for (int t = 1; t <= 60; ++t) {
      Gaussians d = Gradients(n, 10 + t);
      std::vector<uint32_t> groups;
      for (uint32_t g = 0; g < AdamGroupCount(n); ++g)
        if (t <= 3 || t % (g + 2) == 0) groups.push_back(g);
      for (int a = 0; a < kAttributeCount; ++a)
        for (size_t k = 0; k < d.values[a].size(); ++k)
          if (std::count(groups.begin(), groups.end(), k / d.width(a) / kGaussianGroup) == 0)
            d.values[a][k] = 0;
      StepOf(Rates(), d, {}, AllGroups(n), all, all_state);
      StepOf(Rates(), d, {}, groups, some, some_state);
    }
    AdamCatchUpAll(Rates(), {}, some, some_state);
    for (int a = 0; a < kAttributeCount; ++a)
      for (size_t k = 0; k < all.values[a].size(); ++k) {
        EXPECT_NEAR(some_state.m.values[a][k], all_state.m.values[a][k], 1e-6);
        EXPECT_NEAR(some_state.v.values[a][k], all_state.v.values[a][k], 1e-6);
        // In units of a step of full size, of which some went 139. Measured: 0.06, and 0.43
        // where the bias corrections still change.
        EXPECT_NEAR((some.values[a][k] - first.values[a][k]) / Rates().rate[a],
                    (all.values[a][k] - first.values[a][k]) / Rates().rate[a],
                    start == 0 ? 0.6 : 0.1)
            << a;
      }
  }
}

TEST(Adam, WhatWaitsIsLeftAlone) {
  const size_t n = 40;
  const Gaussians start = Gradients(n, 9);
  Gaussians g = start;
  AdamState state(g);
  const std::vector<uint32_t> groups{0, 2};
  StepOf(Rates(), Gradients(n, 10), {}, groups, g, state);
  EXPECT_EQ(state.updated, (Buffer<uint32_t>{1, 0, 1}));
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t k = 0; k < start.values[a].size(); ++k) {
      const bool waits = k / start.width(a) / kGaussianGroup == 1;
      EXPECT_EQ(g.values[a][k] == start.values[a][k], waits) << a;
      EXPECT_EQ(state.v.values[a][k] == 0, waits) << a;
    }
  // Nothing to make up for: it has no momentum yet.
  AdamCatchUpAll(Rates(), {}, g, state);
  EXPECT_EQ(state.updated, (Buffer<uint32_t>{1, 1, 1}));
  for (size_t k = 3 * 16; k < 3 * 32; ++k)
    EXPECT_EQ(g.values[kPosition][k], start.values[kPosition][k]);
}

TEST(Adam, WhatIsPutOffHasItsOwnRateAndEps) {
  // One gradient, then many steps later: the tail is that of a step without a gradient, in sum.
  const size_t n = 16;
  AdamSettings settings = Rates();
  settings.eps[kColorRest] = 0.01f;
  Buffer<float> scale(3 * n);
  for (size_t i = 0; i < scale.size(); ++i) scale[i] = float(i) - 4;
  Gaussians all = Gradients(n, 20), some = all;
  AdamState all_state(all), some_state(all);
  all_state.step = some_state.step = 5000;  // no bias correction left
  some_state.updated.assign(1, 5000);
  const Gaussians d = Gradients(n, 21);
  for (Gaussians* g : {&all, &some})
    StepOf(settings, d, scale, AllGroups(n), *g, g == &all ? all_state : some_state);
  const Gaussians after_one = all;
  for (int t = 0; t < 30; ++t) {
    StepOf(settings, all.ZerosLike(), scale, AllGroups(n), all, all_state);
    StepOf(settings, all.ZerosLike(), scale, {}, some, some_state);
  }
  AdamCatchUpAll(settings, scale, some, some_state);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t k = 0; k < all.values[a].size(); ++k)
      EXPECT_NEAR(some.values[a][k] - after_one.values[a][k],
                  all.values[a][k] - after_one.values[a][k],
                  2e-6 + 0.02 * std::abs(all.values[a][k] - after_one.values[a][k]))
          << a;
}

TEST(Adam, AnyNumberOfStepsCanBePutOff) {
  Gaussians g = Gradients(20, 22);
  AdamState state(g);
  StepOf(Rates(), Gradients(20, 23), {}, AllGroups(20), g, state);
  const Gaussians before = g;
  state.step += 10000000;
  AdamCatchUpAll(Rates(), {}, g, state);
  for (int a = 0; a < kAttributeCount; ++a)
    for (size_t k = 0; k < g.values[a].size(); ++k) {
      EXPECT_NEAR(g.values[a][k], before.values[a][k], 100 * Rates().rate[a]);
      EXPECT_EQ(state.m.values[a][k], 0);
      EXPECT_EQ(state.v.values[a][k], 0);
    }
}

TEST(Adam, BitsDoNotDependOnThreads) {
  const size_t n = 20000;
  Gaussians first;
  for (const int threads : {1, 4}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Gaussians g = Gradients(n, 8);
    AdamState state(g);
    for (uint32_t t = 0; t < 5; ++t) {
      std::vector<uint32_t> groups;  // gaps of different lengths
      for (uint32_t k = 0; k < AdamGroupCount(n); ++k)
        if ((k * 7 + t * 3) % 5 < 2 || t == 0) groups.push_back(k);
      StepOf(Rates(), Gradients(n, 30 + t), {}, groups, g, state);
    }
    AdamCatchUpAll(Rates(), {}, g, state);
    if (threads == 1) first = g;
    for (int a = 0; a < kAttributeCount; ++a) EXPECT_EQ(g.values[a], first.values[a]);
  }
}

TEST(Adam, NothingToUpdate) {
  Gaussians none;
  AdamState state = AdamState(none);
  EXPECT_EQ(StepOf(Rates(), none, {}, {}, none, state), 0u);
}

}  // namespace
}  // namespace cosplat

// A run's state as density control finds it, and two of them compared.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "splat/train/step/step_engine.h"

namespace cosplat::test {

// With random moments and statistics; two of the Gaussians are broken.
inline TrainingState AfterSomeSteps(const Gaussians& gaussians, uint64_t seed) {
  TrainingState state;
  const size_t count = gaussians.size();
  state.gaussians = gaussians;
  state.gaussians.degrees.assign(count, 1);
  state.adam = AdamState(state.gaussians);
  state.adam.step = 7;
  state.adam.updated.assign(state.adam.updated.size(), 7);
  state.statistics.Reset(count);
  Rng rng{seed};
  for (size_t i = 0; i < count; ++i) {
    state.gaussians.degrees[i] = uint8_t(rng.Below(2));
    state.statistics.visible[i] = float(rng.Below(4));
    state.statistics.screen_gradient[i] = 1e-3f * rng.Uniform() * state.statistics.visible[i];
    state.statistics.plasticity[i] = rng.Uniform();
    for (Gaussians* moments : {&state.adam.m, &state.adam.v})
      for (int a = 0; a < kAttributeCount; ++a)
        for (int k = 0; k < state.gaussians.width(a); ++k)
          moments->values[a][i * state.gaussians.width(a) + k] = rng.Uniform();
  }
  state.gaussians.at(kColorRest, 5)[2] = NAN;
  state.gaussians.at(kPosition, 6)[0] = INFINITY;
  state.rng = rng;
  return state;
}

inline void ExpectNear(const Buffer<float>& actual,
                       const Buffer<float>& expected,
                       const char* what) {
  ASSERT_EQ(actual.size(), expected.size()) << what;
  for (size_t i = 0; i < expected.size(); ++i)
    if (std::isfinite(expected[i]))
      ASSERT_NEAR(actual[i], expected[i], 2e-6f * (1 + std::abs(expected[i]))) << what << " " << i;
    else
      ASSERT_FALSE(std::isfinite(actual[i])) << what << " " << i;
}

inline void ExpectSame(const TrainingState& device, const TrainingState& cpu) {
  for (int a = 0; a < kAttributeCount; ++a) {
    ExpectNear(device.gaussians.values[a], cpu.gaussians.values[a], "values");
    ExpectNear(device.adam.m.values[a], cpu.adam.m.values[a], "first moments");
    ExpectNear(device.adam.v.values[a], cpu.adam.v.values[a], "second moments");
  }
  EXPECT_EQ(device.gaussians.degrees, cpu.gaussians.degrees);
  EXPECT_EQ(device.adam.updated, cpu.adam.updated);
  ExpectNear(device.statistics.screen_gradient, cpu.statistics.screen_gradient, "gradients");
  EXPECT_EQ(device.rng.state, cpu.rng.state);
}

}  // namespace cosplat::test

// Density control on the device against the CPU's, from the same state: the same Gaussians, in the
// same order, with the same random numbers.
#include <gtest/gtest.h>

#include <cmath>

#include "splat/cuda/stream.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/training_run.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

class DensityParity : public test::DeviceTest {};

constexpr size_t kCount = 700;

TrainingState StateOf(uint64_t seed) {
  TrainingState state;
  state.gaussians = test::RandomGaussians(kCount, 1, Basis::kDcsh, seed);
  state.gaussians.degrees.assign(kCount, 1);
  state.adam = AdamState(state.gaussians);
  state.adam.step = 7;
  state.adam.updated.assign(state.adam.updated.size(), 7);
  state.statistics.Reset(kCount);
  Rng rng{seed};
  for (size_t i = 0; i < kCount; ++i) {
    state.gaussians.degrees[i] = uint8_t(rng.Below(2));
    state.statistics.visible[i] = float(rng.Below(4));
    state.statistics.screen_gradient[i] = 1e-3f * rng.Uniform() * state.statistics.visible[i];
    state.statistics.plasticity[i] = rng.Uniform();
    state.statistics.max_radius[i] = 40 * rng.Uniform();
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

DensitySettings Settings() {
  DensitySettings settings;
  settings.gradient_threshold = 5e-4f;
  settings.split_scale = 0.1f;
  settings.max_scale = 0.5f;
  settings.max_radius_px = 30;
  return settings;
}

void ExpectNear(const Buffer<float>& actual, const Buffer<float>& expected, const char* what) {
  ASSERT_EQ(actual.size(), expected.size()) << what;
  for (size_t i = 0; i < expected.size(); ++i)
    if (std::isfinite(expected[i]))
      ASSERT_NEAR(actual[i], expected[i], 2e-6f * (1 + std::abs(expected[i]))) << what << " " << i;
    else
      ASSERT_FALSE(std::isfinite(actual[i])) << what << " " << i;
}

void ExpectSame(const TrainingState& device, const TrainingState& cpu) {
  for (int a = 0; a < kAttributeCount; ++a) {
    ExpectNear(device.gaussians.values[a], cpu.gaussians.values[a], "values");
    ExpectNear(device.adam.m.values[a], cpu.adam.m.values[a], "first moments");
    ExpectNear(device.adam.v.values[a], cpu.adam.v.values[a], "second moments");
  }
  EXPECT_EQ(device.gaussians.degrees, cpu.gaussians.degrees);
  EXPECT_EQ(device.adam.updated, cpu.adam.updated);
  ExpectNear(device.statistics.screen_gradient, cpu.statistics.screen_gradient, "gradients");
  ExpectNear(device.statistics.max_radius, cpu.statistics.max_radius, "radii");
  EXPECT_EQ(device.rng.state, cpu.rng.state);
}

// A scene of no pictures: none is drawn here.
struct Both {
  SceneSubject subject{{}, 1};
  TrainSettings settings;
  TrainingState on_cpu, on_device;
  HostStepEngine cpu;
  cuda::DeviceStepEngine device;

  explicit Both(const TrainingState& state, std::shared_ptr<cuda::DeviceSubject> where = nullptr)
      : on_cpu(state),
        on_device(state),
        cpu(settings, subject, on_cpu),
        device(settings, subject, on_device, cuda::SumOrder::kFixed, where) {}

  template <class F>
  void Do(const F& f) {
    f(static_cast<StepEngine&>(cpu));
    f(static_cast<StepEngine&>(device));
    device.Fetch();
    ExpectSame(on_device, on_cpu);
  }
};

TEST_F(DensityParity, CloneSplitAndRemove) {
  for (const bool oversized : {false, true}) {
    Both both(StateOf(3));
    both.Do([&](StepEngine& e) { e.ControlDensity(Settings(), oversized); });
    EXPECT_NE(both.device.count(), kCount);
    both.Do([](StepEngine& e) { e.SortInSpace(); });
    both.Do([](StepEngine& e) { e.ResetOpacity(); });
    both.Do([](StepEngine& e) { e.ResetStatistics(); });
  }
}

TEST_F(DensityParity, TheStrongestGoFirstWhereThereIsALimit) {
  for (const size_t most : {kCount + 40, kCount, size_t(1)}) {
    Both both(StateOf(4));
    DensitySettings settings = Settings();
    settings.max_count = most;
    both.Do([&](StepEngine& e) { e.ControlDensity(settings, false); });
    settings.gradient_threshold = 0;
    both.Do([&](StepEngine& e) { e.ControlDensity(settings, true); });
  }
}

TEST_F(DensityParity, AllMayGo) {
  Both both(StateOf(5));
  DensitySettings settings = Settings();
  settings.min_opacity = 0.999999f;
  settings.gradient_threshold = 10;
  both.Do([&](StepEngine& e) { e.ControlDensity(settings, false); });
  both.Do([](StepEngine& e) { e.SortInSpace(); });
  EXPECT_EQ(both.device.count(), 0u);
}

TEST_F(DensityParity, WhatARoundOfPruningTakes) {
  Both both(StateOf(6));
  PruneRound round;
  Rng rng{1};
  for (size_t i = 0; i < kCount; ++i) round.score.push_back(rng.Uniform());
  round.remove = 123;
  both.Do([&](StepEngine& e) { e.Prune(round, 0, 0); });
  EXPECT_EQ(both.device.count(), kCount - 123);
}

// By way of the host, for subjects with data of their own.
TEST_F(DensityParity, OnTheHost) {
  struct NeedsTheHost : cuda::DeviceSubject {
    bool ControlsDensityOnHost() const override { return true; }
  };
  Both both(StateOf(7), std::make_shared<NeedsTheHost>());
  both.Do([](StepEngine& e) { e.ControlDensity(Settings(), true); });
  PruneRound round;
  round.score.assign(both.device.count(), 1.0f);
  round.remove = 9;
  both.Do([&](StepEngine& e) { e.Prune(round, 0, 0); });
  both.Do([](StepEngine& e) { e.SortInSpace(); });
}

}  // namespace
}  // namespace cosplat

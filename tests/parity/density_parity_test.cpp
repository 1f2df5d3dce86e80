// Density control on the device against the CPU's, from the same state: the same Gaussians, in the
// same order, with the same random numbers.
#include <gtest/gtest.h>

#include "tests/parity/density_state.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/training_run.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

class DensityParity : public test::DeviceTest {};

constexpr size_t kCount = 700;

TrainingState StateOf(uint64_t seed) {
  return test::AfterSomeSteps(test::RandomGaussians(kCount, 1, Basis::kDcsh, seed), seed);
}

DensitySettings Settings() {
  DensitySettings settings;
  settings.gradient_threshold = 5e-4f;
  settings.split_scale = 0.1f;
  settings.max_scale = 0.5f;
  return settings;
}

// A scene of no images: none is drawn here.
struct Both {
  SceneSubject subject{{}, 1};
  TrainSettings settings;
  TrainingState on_cpu, on_device;
  std::unique_ptr<StepEngine> cpu, device;

  explicit Both(const TrainingState& state)
      : on_cpu(state),
        on_device(state),
        cpu(MakeHostStepEngine(settings, subject, on_cpu)),
        device(test::OnDevice(cuda::SumOrder::kFixed)(settings, subject, on_device)) {}

  template <class F>
  void Do(const F& f) {
    f(*cpu);
    f(*device);
    device->Fetch();
    test::ExpectSame(on_device, on_cpu);
  }
};

TEST_F(DensityParity, CloneSplitAndRemove) {
  for (const bool oversized : {false, true}) {
    Both both(StateOf(3));
    both.Do([&](StepEngine& e) { e.ControlDensity(Settings(), oversized); });
    EXPECT_NE(both.device->count(), kCount);
    both.Do([](StepEngine& e) { e.SortInSpace(); });
    both.Do([](StepEngine& e) { e.ResetOpacity(); });
    both.Do([](StepEngine& e) { e.ResetStatistics(); });
  }
}

TEST_F(DensityParity, CutInTwo) {
  Both both(StateOf(5));
  DensitySettings settings = Settings();
  settings.cuts_long_axis = true;
  both.Do([&](StepEngine& e) { e.ControlDensity(settings, false); });
  EXPECT_GT(both.device->count(), kCount);
}

TEST_F(DensityParity, TheStrongestGoFirstWhereThereIsALimit) {
  for (const size_t max : {kCount + 40, kCount, size_t(1)}) {
    Both both(StateOf(4));
    DensitySettings settings = Settings();
    settings.max_count = max;
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
  EXPECT_EQ(both.device->count(), 0u);
}

TEST_F(DensityParity, WhatARoundOfPruningTakes) {
  Both both(StateOf(6));
  PruneRound round;
  Rng rng{1};
  for (size_t i = 0; i < kCount; ++i) round.score.push_back(rng.Uniform());
  round.remove = 123;
  both.Do([&](StepEngine& e) { e.Prune(round, 0, 0); });
  EXPECT_EQ(both.device->count(), kCount - 123);
}

}  // namespace
}  // namespace cosplat

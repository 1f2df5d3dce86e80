// Density control, walking and pruning of an avatar on the device against the CPU's, from the same
// state: the same Gaussians on the same triangles, with the same random numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "avatar/train/avatar_subject.h"
#include "tests/avatar/made_video.h"
#include "tests/parity/density_state.h"
#include "tests/parity/device_fixture.h"

namespace cosplat {
namespace {

class AvatarDensityParity : public test::DeviceTest {};

constexpr size_t kCount = 600;

// One subject and its engine; nothing is drawn but for holes, in frames of 24 x 24 pixels.
struct Side {
  AvatarSubject subject;
  TrainSettings settings;
  TrainingState state;
  std::unique_ptr<StepEngine> engine;

  Side(const AvatarSettings& avatar, bool on_device)
      : subject(test::MadeHead().model, test::MakeSmallVideo(4, 4), avatar) {
    state = test::AfterSomeSteps(FirstGaussians(), 5);
    engine =
        AvatarEngineOn(on_device ? Device::kCuda : Device::kCpu, true)(settings, subject, state);
  }

 private:
  // Opaque, as wide as they are apart, pushed off their places.
  Gaussians FirstGaussians() {
    Gaussians g = subject.InitialGaussians(1, Basis::kDcsh, 3);
    Rng rng{4};
    for (size_t i = 0; i < g.size(); ++i) {
      g.at(kOpacityLogit, i)[0] = i % 7 == 0 ? -6.0f : 5.0f;
      for (int k = 0; k < 2; ++k) g.at(kPosition, i)[k] = 0.8f * rng.Normal();
      g.at(kPosition, i)[2] = 0.002f * rng.Normal();
      for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] += 0.3f * rng.Normal();
      for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rng.Normal();
    }
    return g;
  }
};

struct Both {
  Side cpu, device;

  explicit Both(AvatarSettings avatar) : cpu(avatar, false), device(avatar, true) {}

  template <class F>
  void Do(const F& f) {
    f(*cpu.engine);
    f(*device.engine);
    device.engine->Fetch();
    test::ExpectSame(device.state, cpu.state);
    const AvatarTrainingState got = device.subject.State(), expected = cpu.subject.State();
    EXPECT_EQ(got.first_triangle, expected.first_triangle);
    ASSERT_EQ(got.embedding.triangle, expected.embedding.triangle);
    for (size_t i = 0; i < expected.embedding.barycentric.size(); ++i)
      for (int k = 0; k < 2; ++k)
        // Walks in a row: with multiplications and additions fused on one side alone (tests/cuda)
        // the largest difference is 3.9e-6.
        ASSERT_NEAR(got.embedding.barycentric[i][k], expected.embedding.barycentric[i][k], 2e-5f);
  }
  size_t count() const { return device.engine->count(); }
};

AvatarSettings Avatar(AvatarSystem system = AvatarSystem::kCosplat) {
  AvatarSettings avatar = test::SmallAvatar(kCount);
  avatar.system = system;
  avatar.walk_every = 4;
  return avatar;
}

// Splits what is wider than most.
DensitySettings Settings() {
  DensitySettings settings;
  settings.gradient_threshold = 5e-4f;
  settings.split_scale = 0.02f;
  settings.max_scale = 0.05f;
  return settings;
}

TEST_F(AvatarDensityParity, CloneSplitRemoveWalkAndSort) {
  for (const AvatarSystem system : {AvatarSystem::kCosplat, AvatarSystem::kPublished}) {
    Both both(Avatar(system));
    both.Do([](StepEngine& e) { e.AfterStep(3); });
    EXPECT_EQ(both.device.subject.WalkedShare(), 0) << "every fourth step alone";
    both.Do([](StepEngine& e) { e.AfterStep(4); });
    EXPECT_GT(both.device.subject.WalkedShare(), 0.1);
    for (const bool oversized : {false, true}) {
      const size_t before = both.count();
      both.Do([&](StepEngine& e) { e.ControlDensity(Settings(), oversized); });
      EXPECT_NE(both.count(), before);
      both.Do([](StepEngine& e) { e.SortInSpace(); });
    }
    both.Do([](StepEngine& e) { e.AfterStep(8); });
  }
}

PruneRound RoundOf(size_t count, size_t remove) {
  PruneRound round;
  Rng rng{2};
  for (size_t i = 0; i < count; ++i) round.score.push_back(rng.Uniform());
  round.remove = remove;
  return round;
}

// Most of them would go, and with them what covers the head.
TEST_F(AvatarDensityParity, PruningTearsNoHole) {
  size_t left[2];
  for (const bool guarded : {true, false}) {
    Both both(Avatar(guarded ? AvatarSystem::kCosplat : AvatarSystem::kPublished));
    const size_t before = both.count();
    both.Do([&](StepEngine& e) { e.Prune(RoundOf(before, before * 3 / 4), 0, 0); });
    left[guarded] = both.count();
  }
  EXPECT_EQ(left[false], kCount - kCount * 3 / 4);
  EXPECT_GT(left[true], left[false] + 10) << "some had to stay";
}

TEST_F(AvatarDensityParity, TrianglesKeepToFloorAndCap) {
  Both both(Avatar());
  DensitySettings all;
  all.gradient_threshold = 0;  // clones
  all.split_scale = 1;
  for (int round = 0; round < 3; ++round)
    both.Do([&](StepEngine& e) { e.ControlDensity(all, false); });
  const size_t before = both.count();
  both.Do([&](StepEngine& e) { e.Prune(RoundOf(before, before / 3), 5, 2); });
  EXPECT_LT(both.count(), before);
  std::map<int32_t, int> count;
  const AvatarTrainingState state = both.device.subject.State();
  for (const int32_t t : state.embedding.triangle) ++count[t];
  for (const auto& [triangle, n] : count) EXPECT_LE(n, 5) << triangle;
}

TEST_F(AvatarDensityParity, RefinedFramesAreLookedAtAsTheyStand) {
  AvatarSettings avatar = Avatar();
  avatar.refine_track = true;
  Both both(avatar);
  const size_t before = both.count();
  for (const size_t share : {2, 3})
    both.Do([&](StepEngine& e) { e.Prune(RoundOf(e.count(), e.count() / share), 0, 0); });
  EXPECT_LT(both.count(), before);
}

}  // namespace
}  // namespace cosplat

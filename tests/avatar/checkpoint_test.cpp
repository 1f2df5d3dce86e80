// Checkpoints of avatars: walks, the refined track, the bust's track and corrections go on bit for
// bit.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <memory>

#include "splat/base/state_file.h"
#include "tests/avatar/training_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small avatars

constexpr int kAvatarSteps = 90;

struct AvatarRun : Training<> {
  explicit AvatarRun(const AvatarSettings& avatar)
      : Training<>(LoadSmallVideo(6, 2), avatar, Settings()) {}
  static TrainSettings Settings() {
    TrainSettings settings = test::ShortRun(kAvatarSteps, 3000);
    settings.prune.rule = "dcsharp";
    settings.schedule.opacity_reset_every = 35;
    return settings;
  }
  void Until(int step) {
    while (trainer.iteration() < step) trainer.Step();
  }
};

AvatarSettings AllThatMoves() {
  AvatarSettings avatar = SmallAvatar(1500);
  avatar.refine_track = true;
  avatar.corrections = 2;
  avatar.bust = AvatarSettings::BustChoice::kYes;
  avatar.walk_every = 10;
  avatar.iterations = kAvatarSteps;
  return avatar;
}

bool SameAvatar(AvatarRun& a, AvatarRun& b) {
  const TrainingState &s = a.trainer.state(), &t = b.trainer.state();
  for (int k = 0; k < kAttributeCount; ++k)
    if (s.gaussians.values[k] != t.gaussians.values[k] ||
        s.adam.m.values[k] != t.adam.m.values[k] || s.adam.v.values[k] != t.adam.v.values[k])
      return false;
  const AvatarTrainingState x = a.subject.State(), y = b.subject.State();
  bool same = x.embedding.triangle == y.embedding.triangle &&
              x.embedding.barycentric == y.embedding.barycentric &&
              x.first_triangle == y.first_triangle && x.track.size() == y.track.size() &&
              x.busts.size() == y.busts.size() && x.lights.size() == 1 && y.lights.size() == 1 &&
              std::memcmp(x.lights.data(), y.lights.data(), sizeof(LightState)) == 0 &&
              std::memcmp(x.busts.data(), y.busts.data(), x.busts.size() * sizeof(BustState)) == 0;
  for (size_t i = 0; same && i < x.track.size(); ++i)
    same = x.track[i].params.expression == y.track[i].params.expression &&
           x.track[i].params.pose == y.track[i].params.pose && x.track[i].step == y.track[i].step;
  return same;
}

void ExpectExactAvatar(const AvatarSettings& avatar) {
  const TemporaryFolder folder;
  const std::string path = folder / "checkpoint";
  AvatarRun undisturbed(avatar);
  undisturbed.Until(kAvatarSteps);
  auto run = std::make_unique<AvatarRun>(avatar);
  size_t threads = 2;
  for (const int stop : {7, 30, 35, 61, 89}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    threads = 3 - threads;
    run->Until(stop);
    WriteStateFile(path, "", [&](StateArchive& a) { run->trainer.Serialize(a); });
    run = std::make_unique<AvatarRun>(avatar);
    StateFile(path).Read([&](StateArchive& a) { run->trainer.Serialize(a); });
  }
  run->Until(kAvatarSteps);
  EXPECT_GT(run->subject.WalkedShare(), 0);
  EXPECT_TRUE(SameAvatar(undisturbed, *run));
}

TEST(AvatarCheckpoint, ARunGoesOnBitForBit) { ExpectExactAvatar(AllThatMoves()); }

TEST(AvatarCheckpoint, AlsoWithATrackThatIsNotRefined) {
  AvatarSettings avatar = AllThatMoves();
  avatar.refine_track = false;
  ExpectExactAvatar(avatar);
}

TEST(AvatarCheckpoint, OfAnotherMeshIsAnError) {
  AvatarRun run(SmallAvatar(200));
  AvatarTrainingState state = run.subject.State();
  state.embedding.triangle[7] = 1000000;
  ExpectError([&] { run.subject.RestoreState(state); }, {"embedding.triangle", "1000000"});
}

}  // namespace
}  // namespace cosplat

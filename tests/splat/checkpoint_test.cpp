// Checkpoints: a run that goes on from one has the bits of the run that was never interrupted,
// whatever it keeps between steps; and a damaged one is found.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <fstream>

#include "splat/base/files.h"
#include "splat/base/state_file.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using namespace test;  // NOLINT: small scenes

constexpr int kSteps = 150;

std::vector<TrainFrame> Frames() { return TargetImages(TrueScene(2), Ring(6, 2.2f), true); }

// A run with densification, resets of opacity, degrees that rise, and random backgrounds.
TrainSettings Busy(const std::string& rule = "none") {
  TrainSettings settings = ShortRun(kSteps, 2);
  settings.schedule.densify_from = 10;
  settings.schedule.densify_until = 100;
  settings.schedule.opacity_reset_every = 60;
  settings.schedule.degree_every = 40;
  settings.background = Background::kRandom;
  settings.prune.rule = rule;
  return settings;
}

struct SceneRun {
  SceneSubject subject{Frames(), 1};
  Trainer trainer;

  explicit SceneRun(const TrainSettings& settings)
      : trainer(settings, subject, FirstGaussians(300, 2)) {}
  void Until(int step) {
    while (trainer.iteration() < step) trainer.Step();
  }
  void Write(const std::string& path) {
    WriteStateFile(path, "a run", [&](StateArchive& a) { trainer.Serialize(a); });
  }
  void Read(const std::string& path) {
    StateFile(path).Read([&](StateArchive& a) { trainer.Serialize(a); });
  }
};

bool SameRun(SceneRun& a, SceneRun& b) {
  return SameBits(a.trainer.state(), b.trainer.state()) &&
         a.trainer.state().gaussians.degrees == b.trainer.state().gaussians.degrees &&
         a.trainer.statistics().drop_psnr == b.trainer.statistics().drop_psnr;
}

// Interrupted at each of these steps, each time resumed in a new trainer on other threads.
void ExpectExact(const TrainSettings& settings, const std::vector<int>& stops) {
  const TemporaryFolder folder;
  SceneRun undisturbed(settings);
  undisturbed.Until(kSteps);
  auto run = std::make_unique<SceneRun>(settings);
  size_t threads = 1;
  for (const int stop : stops) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    threads = 3 - threads;
    run->Until(stop);
    run->Write(folder / "checkpoint");
    run = std::make_unique<SceneRun>(settings);
    run->Read(folder / "checkpoint");
    EXPECT_EQ(run->trainer.iteration(), stop);
  }
  run->Until(kSteps);
  EXPECT_TRUE(SameRun(undisturbed, *run)) << settings.prune.rule;
  EXPECT_EQ(run->trainer.statistics().steps, size_t(kSteps));
}

TEST(Checkpoint, ARunGoesOnBitForBit) { ExpectExact(Busy(), {1, 9, 10, 31, 60, 99, 149}); }

TEST(Checkpoint, AlsoWithEveryRuleOfPruning) {
  for (const std::string& name : PruneRuleNames()) ExpectExact(Busy(name), {15, 47, 97, 99, 101});
}

TEST(Checkpoint, AlsoWithAntialiasing) {
  TrainSettings settings = Busy();
  settings.antialiasing = true;
  ExpectExact(settings, {15, 99, 101, 149});
}

TEST(Checkpoint, AlsoWithExposures) {
  TrainSettings settings = Busy();
  settings.exposure = true;
  ExpectExact(settings, {1, 15, 101, 149});
}

TEST(Checkpoint, AlsoWithDroppedBandsAndATarget) {
  TrainSettings settings = Busy("leave-one-out");
  settings.prune.target = 150;
  settings.drop_bands = 0.02f;
  settings.schedule.num_downscales = 1;
  ExpectExact(settings, {20, 120, 149});
}

TEST(Checkpoint, WritingOneChangesNothing) {
  const TemporaryFolder folder;
  SceneRun once(Busy("compact")), often(Busy("compact"));
  once.Until(60);
  for (int i = 1; i <= 60; ++i) {
    often.Until(i);
    often.Write(folder / "checkpoint");
  }
  EXPECT_TRUE(SameRun(once, often));
}

TEST(Checkpoint, IsLittleLargerThanParametersAndMoments) {
  const TemporaryFolder folder;
  SceneRun run(Busy());
  run.Until(80);
  run.Write(folder / "checkpoint");
  size_t numbers = 0;
  for (const Buffer<float>& values : run.trainer.state().gaussians.values) numbers += values.size();
  const size_t size = std::filesystem::file_size(folder / "checkpoint");
  EXPECT_LT(double(size), 1.1 * double(3 * sizeof(float) * numbers));
}

std::string Bytes(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

TEST(Checkpoint, FlippedBitsAreFound) {
  const TemporaryFolder folder;
  const std::string path = folder / "checkpoint";
  SceneSubject subject({Frames()[0]}, 1);
  Trainer trainer(ShortRun(10, 0), subject, TrueScene(0, 2));
  WriteStateFile(path, "a run", [&](StateArchive& a) { trainer.Serialize(a); });
  const std::string good = Bytes(path);
  ASSERT_LT(good.size(), 10000u);
  EXPECT_EQ(StateFile(path).header(), "a run");
  for (size_t bit = 0; bit < 8 * good.size(); bit += bit < 8 * 64 ? 1 : 61) {
    std::string damaged = good;
    damaged[bit / 8] = char(damaged[bit / 8] ^ (1 << bit % 8));
    std::ofstream(path, std::ios::binary) << damaged;
    ExpectError([&] { StateFile{path}; }, {path, "damaged"});
  }
  for (size_t size = 0; size < good.size(); size += 97) {
    std::ofstream(path, std::ios::binary) << good.substr(0, size);
    ExpectError([&] { StateFile{path}; }, {path});
  }
}

TEST(Checkpoint, OfAnotherRunIsAnErrorThatNamesTheField) {
  const TemporaryFolder folder;
  SceneRun run(Busy());
  run.Until(20);
  run.Write(folder / "checkpoint");
  const StateFile file(folder / "checkpoint");
  const auto read_into = [&](Trainer& trainer) {
    return [&] { file.Read([&](StateArchive& a) { trainer.Serialize(a); }); };
  };
  SceneSubject few({Frames()[0]}, 1);
  Trainer other_frames(Busy(), few, FirstGaussians(300, 2));
  ExpectError(read_into(other_frames), {file.path(), "frames_left"});
  SceneSubject all(Frames(), 1);
  TrainSettings lower = Busy();
  lower.degree = 1;
  Trainer other_degree(lower, all, FirstGaussians(300, 1));
  ExpectError(read_into(other_degree), {file.path(), "gaussians.color_rest", "elements"});
  TrainSettings shorter = Busy();
  shorter.iterations = 10;
  Trainer other_length(shorter, all, FirstGaussians(300, 2));
  ExpectError(read_into(other_length), {file.path(), "iteration"});
}

}  // namespace
}  // namespace cosplat

// Trainings that are killed at random moments (SIGKILL) and resumed leave, byte for byte, what an
// undisturbed run leaves: every file but the configuration, and of stats.json what is not time.
//
// A few kills per kind of run; COSPLAT_KILLS=100 sets another number for all of them together,
// COSPLAT_KILL_SEED other moments.
#include <gtest/gtest.h>

#include "splat/base/rng.h"
#include "tests/integration/background_command.h"
#include "tests/integration/run_files.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPatience = 600;  // seconds

struct Kind {
  const char* name;
  bool avatar;
  std::vector<std::string> arguments;
};

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kinds{
      {"avatar, track refined",
       true,
       {"--iterations",
        "500",
        "--refine-track",
        "--save_iterations",
        "200",
        "--test_iterations",
        "200"}},
      {"avatar, corrections and bust",
       true,
       {"--iterations", "400", "--corrections", "2", "--bust", "yes"}},
      {"avatar, pruned to a count", true, {"--iterations", "500", "--prune-to", "1200"}},
      {"avatar, budget", true, {"--iterations", "150", "--budget", "auto"}},
      {"scene", false, {"--iterations", "1500", "--max-gaussians", "900"}},
      {"scene, learned mask and bands",
       false,
       {"--iterations", "1200", "--prune", "lp", "--drop-bands", "2"}},
      {"scene, budget", false, {"--iterations", "500", "--budget", "auto"}},
  };
  return kinds;
}

std::vector<std::string> CommandOf(const Kind& kind, const std::string& out) {
  const Workshop& made = Workshop::Get();
  std::vector<std::string> line;
  if (kind.avatar)
    line = {"train-avatar", "-s", made.head, "--flame", made.model, "--gaussians", "1500"};
  else
    line = {"train-scene", "-s", made.photos, "--random-points", "600"};
  line.insert(line.end(), {"-m", out, "--eval", "--quiet"});
  line.insert(line.end(), kind.arguments.begin(), kind.arguments.end());
  return line;
}

struct Tally {
  int kills = 0, runs = 0, resumed = 0;
};

// Kills runs of this kind so many times in all, and lets each end at last.
void KillRuns(const Kind& kind, int kills, Rng& rng, Tally& tally) {
  const TemporaryFolder folder;
  const std::string log = folder / "log", reference = folder / "reference", out = folder / "run";
  const double start = Seconds();
  std::vector<std::string> undisturbed = CommandOf(kind, reference);
  undisturbed.insert(undisturbed.end(), {"--threads", "1"});
  BackgroundCommand whole(undisturbed, log);
  ASSERT_TRUE(whole.EndsWithin(kPatience)) << kind.name;
  ASSERT_EQ(whole.status(), 0) << kind.name << "\n" << Slurp(log);
  const double seconds = Seconds() - start;
  const auto expected = FilesOf(reference);
  ASSERT_TRUE(expected.count("results.json"));
  std::vector<std::string> command = CommandOf(kind, out);
  command.insert(command.end(), {"--resume", "--checkpoint-every", "0.002", "--threads", "1"});
  for (int done = 0, started = 0;; ++started) {
    command.back() = started % 2 == 0 ? "2" : "1";
    tally.resumed += fs::exists(out + "/checkpoint.bin");
    BackgroundCommand run(command, log);
    if (!run.EndsWithin(done < kills ? rng.Uniform() * seconds : kPatience)) {
      ASSERT_LT(done, kills) << kind.name;
      run.Signal(SIGKILL);
      ASSERT_TRUE(run.EndsWithin(kPatience));
      if (run.status() == 128 + SIGKILL) {  // or it ended just before
        ++done;
        ++tally.kills;
        continue;
      }
    }
    ASSERT_EQ(run.status(), 0) << kind.name << "\n" << Slurp(log);
    ++tally.runs;
    ExpectSameFiles(expected, FilesOf(out), kind.name);
    if (done >= kills || ::testing::Test::HasFailure()) return;
    fs::remove_all(out);
  }
}

TEST(Kill, ResumedRunsLeaveTheBytesOfUndisturbedOnes) {
  const char* const text = std::getenv("COSPLAT_KILLS");
  const char* const seed = std::getenv("COSPLAT_KILL_SEED");
  const int kinds = int(Kinds().size()), kills = text ? std::atoi(text) : 2 * kinds;
  Rng rng{seed ? std::strtoull(seed, nullptr, 10) : 1};
  Tally tally;
  for (int k = 0; k < kinds; ++k)
    KillRuns(Kinds()[size_t(k)], kills / kinds + (k < kills % kinds), rng, tally);
  std::printf(
      "%d kills in %d runs, %d starts from a checkpoint\n", tally.kills, tally.runs, tally.resumed);
  EXPECT_GT(tally.resumed, 0);
}

}  // namespace
}  // namespace cosplat::test

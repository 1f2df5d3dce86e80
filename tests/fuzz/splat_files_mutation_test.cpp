// Splat files of other programs that are nearly good, under fixed seeds: a reader either returns
// Gaussians of finite numbers or throws Error of one line.
#include <gtest/gtest.h>

#include "tests/fuzz/mutate.h"
#include "tests/fuzz/splat_check.h"

namespace cosplat {
namespace {

constexpr int kFiles = 1500;  // per layout

struct SplatOutcome {
  int good = 0, refused = 0;
};

SplatOutcome ReadMutations(const std::vector<std::string>& seeds, const char* name, uint64_t seed) {
  const test::TemporaryFolder folder;
  Rng rng{seed};
  SplatOutcome outcome;
  for (int i = 0; i < kFiles; ++i) {
    bool good = false;
    const std::string bytes = test::Mutated(seeds[rng.Below(seeds.size())], seeds, rng);
    EXPECT_EQ(test::SplatProblem(folder / name, bytes, good), "") << "file " << i;
    ++(good ? outcome.good : outcome.refused);
  }
  return outcome;
}

// Of layouts that are compressed most mutations end in a checksum. The plain bytes within are
// mutated as well.
TEST(SplatFileMutations, OfSpz) {
  const test::SplatSeeds seeds;
  const SplatOutcome outcome = ReadMutations({seeds.spz3, seeds.spz4}, "a.spz", 1);
  EXPECT_GT(outcome.refused, kFiles / 2);
}

TEST(SplatFileMutations, OfSpzBeforeGzip) {
  const test::SplatSeeds seeds;
  const test::TemporaryFolder folder;
  Rng rng{2};
  int good = 0;
  for (int i = 0; i < kFiles; ++i) {
    bool read = false;
    const std::string bytes = Gzip(test::Mutated(seeds.spz3_plain, {seeds.spz3_plain}, rng));
    EXPECT_EQ(test::SplatProblem(folder / "a.spz", bytes, read), "") << "file " << i;
    good += read;
  }
  EXPECT_GT(good, kFiles / 50);
}

TEST(SplatFileMutations, OfSog) {
  const test::SplatSeeds seeds;
  const SplatOutcome outcome = ReadMutations({seeds.sog}, "a.sog", 3);
  EXPECT_GT(outcome.refused, kFiles / 4);
}

TEST(SplatFileMutations, OfSogMeta) {
  const test::SplatSeeds seeds;
  const test::TemporaryFolder folder;
  Rng rng{4};
  for (int i = 0; i < kFiles; ++i) {
    bool read = false;
    const std::string bytes =
        seeds.SogWithMeta(test::Mutated(seeds.sog_meta, {seeds.sog_meta}, rng), folder / "b.sog");
    EXPECT_EQ(test::SplatProblem(folder / "a.sog", bytes, read), "") << "file " << i;
  }
}

TEST(SplatFileMutations, OfSplatRecords) {
  const test::SplatSeeds seeds;
  const SplatOutcome outcome = ReadMutations({seeds.records}, "a.splat", 5);
  EXPECT_GT(outcome.good, kFiles / 10);
  EXPECT_GT(outcome.refused, kFiles / 10);
}

TEST(SplatFileMutations, OfGlbAndPly) {
  const test::SplatSeeds seeds;
  ReadMutations({seeds.glb}, "a.glb", 6);
  ReadMutations({seeds.ply}, "a.ply", 7);
}

}  // namespace
}  // namespace cosplat

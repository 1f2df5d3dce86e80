// Inputs of every reader that are nearly good, under fixed seeds: a reader returns what is sane or
// throws Error of one line.
#include <gtest/gtest.h>

#include "tests/fuzz/mutate.h"
#include "tests/fuzz/reader.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

constexpr int kInputs = 2000;  // per reader

class ReaderMutations : public testing::TestWithParam<FuzzedReader> {
 protected:
  TemporaryFolder folder_;
  ReaderRun run_{GetParam(), folder_.path()};
};

TEST_P(ReaderMutations, SeedsAreAccepted) {
  for (const std::string& seed : GetParam().seeds()) {
    bool good = false;
    EXPECT_EQ(run_.Problem(seed, good), "");
    EXPECT_TRUE(good) << run_.refusal();
  }
}

TEST_P(ReaderMutations, AreReadOrRefused) {
  const std::vector<std::string> seeds = GetParam().seeds();
  Rng rng{1};
  int refused = 0;
  for (int i = 0; i < kInputs; ++i) {
    const std::string& seed = seeds[rng.Below(seeds.size())];
    bool good = false;
    ASSERT_EQ(run_.Problem(Mutated(seed, seeds, rng, GetParam().words), good), "") << "input " << i;
    refused += !good;
  }
  EXPECT_GT(refused, kInputs / 50);
}

INSTANTIATE_TEST_SUITE_P(,
                         ReaderMutations,
                         testing::ValuesIn(FuzzedReaders()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace cosplat::test

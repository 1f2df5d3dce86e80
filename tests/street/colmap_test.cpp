// `cosplat scene` with a program of each of COLMAP's dialects: 3.8's and 4.2's.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/fake_colmap.h"

namespace cosplat::test {
namespace {

TEST(ColmapProgram, GetsTheOptionsThatItTakes) {
  for (const Dialect dialect : {Dialect::k38, Dialect::k42}) {
    const FakeColmap fake(kViews, dialect);
    const CommandResult result = fake.Run({"--cameras-only"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(Contains(result.out, "cameras of 10 of 10 photographs")) << result.out;
    const std::vector<std::string> calls = fake.TakeCalls();
    ASSERT_EQ(calls.size(), 4u);
    const bool is_new = dialect == Dialect::k42;
    const std::string extraction = is_new ? "--FeatureExtraction." : "--SiftExtraction.";
    EXPECT_TRUE(Contains(calls[0], extraction + "use_gpu 0 ")) << calls[0];
    EXPECT_TRUE(Contains(calls[0], extraction + "max_image_size 1600 ")) << calls[0];
    EXPECT_TRUE(Contains(calls[0], "--SiftExtraction.max_num_features 4096")) << calls[0];
    EXPECT_TRUE(
        Contains(calls[1], is_new ? "--FeatureMatching.use_gpu 0" : "--SiftMatching.use_gpu 0"))
        << calls[1];
    for (const std::string& call : calls) EXPECT_EQ(Contains(call, "--log_target"), is_new) << call;
  }
}

TEST(ColmapProgram, IsAskedOnce) {
  const FakeColmap fake(kViews, Dialect::k42);
  ASSERT_EQ(fake.Run({"--cameras-only"}).code, 0);
  std::vector<std::string> questions = fake.TakeQuestions();
  EXPECT_EQ(questions.size(), 5u);
  std::sort(questions.begin(), questions.end());
  EXPECT_EQ(std::unique(questions.begin(), questions.end()), questions.end());
}

TEST(ColmapProgram, FeaturesOfThePersonsChoiceGoToTheCommandsThatTakeThem) {
  const FakeColmap fake(kViews, Dialect::k42);
  const CommandResult result = fake.Run({"--colmap-features",
                                         "FeatureExtraction.type=ALIKED_N16ROT",
                                         "--colmap-features",
                                         "FeatureMatching.type=ALIKED_LIGHTGLUE",
                                         "--colmap-features",
                                         "--FeatureExtraction.max_image_size=800"});
  ASSERT_EQ(result.code, 0) << result.err;
  const std::vector<std::string> calls = fake.TakeCalls();
  EXPECT_TRUE(Contains(calls[0], "--FeatureExtraction.type ALIKED_N16ROT")) << calls[0];
  EXPECT_TRUE(Contains(calls[0], "--FeatureExtraction.max_image_size 800")) << calls[0];
  EXPECT_FALSE(Contains(calls[0], "1600") || Contains(calls[0], "FeatureMatching")) << calls[0];
  EXPECT_TRUE(Contains(calls[1], "--FeatureMatching.type ALIKED_LIGHTGLUE")) << calls[1];
  const CommandResult again = Cosplat({"scene", "--config", fake.out + "/config.ini"});
  EXPECT_TRUE(Contains(again.out, "kept from an earlier run")) << again.out << again.err;
  // Other features are another data set, and COLMAP would keep those of the database.
  ASSERT_EQ(fake.Run({"--cameras-only", "--overwrite"}).code, 0);
  EXPECT_EQ(fake.TakeCalls().size(), 4u);
  EXPECT_EQ(Slurp(fake.out + "/colmap/database.db"), "made\n");
}

TEST(ColmapProgram, FeaturesThatItDoesNotHaveAreNamed) {
  const FakeColmap fake;
  const auto refused = [&](const std::string& feature) {
    const CommandResult result = fake.Run({"--cameras-only", "--colmap-features", feature});
    EXPECT_EQ(result.code, 2) << result.out;
    EXPECT_TRUE(fake.TakeCalls().empty());
    return result.err;
  };
  const std::string err = refused("FeatureExtraction.type=ALIKED_N16ROT");
  EXPECT_TRUE(Contains(err, "--colmap-features --FeatureExtraction.type: is taken by neither"))
      << err;
  EXPECT_TRUE(Contains(refused("ALIKED"), "--colmap-features ALIKED: is not NAME=VALUE"));
  EXPECT_TRUE(Contains(refused("--=3"), "is not NAME=VALUE"));
}

TEST(ColmapProgram, ColoursAreNotShown) {
  const FakeColmap fake(kViews, Dialect::k42);
  fake.WriteProgram(
      "[ $command = mapper ] && { printf '\\033[31mE2026 failed\\033[0m\\n    @     0x7f main\\n' "
      ">&2; "
      "exit 3; }");
  const CommandResult result = fake.Run();
  EXPECT_EQ(result.code, 2);
  EXPECT_TRUE(Contains(result.err, "  E2026 failed\n")) << result.err;
  EXPECT_FALSE(Contains(result.err, "\033") || Contains(result.err, "0x7f")) << result.err;
}

// 4.2 writes them beside the model.
TEST(ColmapProgram, RigsAndFramesAreReadPast) {
  const FakeColmap fake(kViews, Dialect::k42);
  std::ofstream(fake.folder / "model/rigs.txt") << "1 1 CAMERA 1\n";
  std::ofstream frames(fake.folder / "model/frames.txt");
  for (int i = 1; i <= kViews; ++i) frames << i << " 1 1 0 0 0 0 0 0 1 CAMERA 1 " << i << "\n";
  frames.close();
  ASSERT_EQ(fake.Run({"--cameras-only"}).code, 0);
  const FakeColmap without;
  ASSERT_EQ(without.Run({"--cameras-only"}).code, 0);
  for (const char* name : {"images", "cameras"}) {
    const std::string file = std::string("/data/sparse/0/") + name + ".txt";
    EXPECT_EQ(Slurp(fake.out + file), Slurp(without.out + file));
  }
}

TEST(ColmapProgram, AnotherProgramIsNoColmap) {
  const FakeColmap fake;
  const auto refused = [&](const std::string& script) {
    std::ofstream(fake.program) << script;
    const CommandResult result = fake.Run();
    EXPECT_EQ(result.code, 2) << result.out;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(fake.out));
    return result.err;
  };
  EXPECT_TRUE(Contains(refused("#!/bin/sh\nexit 1\n"), "bin/colmap: is not COLMAP"));
  EXPECT_TRUE(
      Contains(refused("#!/bin/sh\nkill -11 $$\n"), "`help` of it was killed by signal 11"));
  EXPECT_TRUE(Contains(refused("#!/bin/sh\nwhile echo help; do :; done\n"), "is not COLMAP"));
  EXPECT_TRUE(Contains(refused("\x7f"
                               "ELF"),
                       "cannot be started"));
}

}  // namespace
}  // namespace cosplat::test

// train-scene --blocks: one scene at the end, the same bytes however it came about; what it does
// not go with is one line.
#include <gtest/gtest.h>

#include "tests/integration/background_command.h"
#include "tests/integration/run_files.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> InBlocks(const std::string& out,
                                  const std::vector<std::string>& more,
                                  int iterations = 400) {
  return MadeSceneTraining(out, iterations, 900, [&] {
    std::vector<std::string> all{"--blocks", "3", "--exposure", "--antialiasing"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }());
}

double Psnr(const std::string& out, int iterations) {
  return ReadJson(out + "/results.json")["ours_" + std::to_string(iterations)]["PSNR"];
}

TEST(BlocksCommand, LeaveOneSceneAsGoodAsOnePiece) {
  const TemporaryFolder folder;
  const std::string blocks = folder / "blocks", whole = folder / "whole";
  WriteBallScene(folder / "photos", 30);
  const auto train = [&](const std::string& out, const std::string& count) {
    return Cosplat({"train-scene",
                    "-s",
                    folder / "photos",
                    "-m",
                    out,
                    "--eval",
                    "--iterations",
                    "3000",
                    "--random-points",
                    "900",
                    "--max-gaussians",
                    "1500",
                    "--blocks",
                    count});
  };
  const CommandResult trained = train(blocks, "3");
  ASSERT_EQ(trained.code, 0) << trained.err;
  for (const char* part : {"1,500 Gaussians in 3 blocks", "block 3: ", "30 of 30 views", "PSNR"})
    EXPECT_NE(trained.out.find(part), std::string::npos) << part << "\n" << trained.out;
  EXPECT_NE(trained.err.find("block 3 of 3"), std::string::npos) << trained.err;
  ASSERT_EQ(train(whole, "1").code, 0);
  EXPECT_GT(Psnr(blocks, 3000), Psnr(whole, 3000) - 0.6);
  const Json stats = ReadJson(blocks + "/stats.json");
  ASSERT_EQ(stats["blocks"].size(), 3u);
  size_t sum = 0;
  for (const Json& block : stats["blocks"]) {
    EXPECT_LE(block["gaussians"], 500);
    sum += size_t(block["gaussians"]);
  }
  EXPECT_EQ(stats["gaussians"], sum);
  EXPECT_FALSE(fs::exists(blocks + "/blocks"));
  EXPECT_FALSE(fs::exists(blocks + "/checkpoint.bin"));
  // What it saved is what it measured.
  ASSERT_EQ(Cosplat({"render", "-m", blocks, "-o", folder / "images", "--quiet"}).code, 0);
  EXPECT_EQ(Slurp(folder / "images/00001.png"),
            Slurp(blocks + "/test/ours_3000/renders/00001.png"));
}

TEST(BlocksCommand, HaveTheSameBytesOnAnyNumberOfThreadsAndWithinMemory) {
  const TemporaryFolder folder;
  ASSERT_EQ(Cosplat(InBlocks(folder / "one", {"--threads", "1", "--batch", "2"})).code, 0);
  ASSERT_EQ(Cosplat(InBlocks(folder / "two", {"--threads", "2", "--batch", "2"})).code, 0);
  ExpectSameFiles(FilesOf(folder / "one"), FilesOf(folder / "two"), "two threads");
  // All photographs are kept, none is without --memory.
  ASSERT_EQ(Cosplat(InBlocks(folder / "kept", {"--memory", "5", "--batch", "2"})).code, 0);
  ExpectSameFiles(FilesOf(folder / "one"), FilesOf(folder / "kept"), "photographs in memory");
}

// Stopped again and again, at a checkpoint or killed between two.
TEST(BlocksCommand, GoOnToTheSameBytes) {
  const TemporaryFolder folder;
  ASSERT_EQ(Cosplat(InBlocks(folder / "whole", {"--quiet"})).code, 0);
  const std::string out = folder / "out", log = folder / "log";
  const auto arguments = InBlocks(out, {"--quiet", "--resume", "--checkpoint-every", "0.001"});
  int interrupted = 0;
  for (double patience = 0.03;; patience *= 1.15) {
    BackgroundCommand run(arguments, log);
    if (run.EndsWithin(patience)) {
      ASSERT_EQ(run.status(), 0) << Slurp(log);
      break;
    }
    const int signal = ++interrupted % 2 == 0 ? SIGTERM : SIGKILL;
    run.Signal(signal);
    ASSERT_TRUE(run.EndsWithin(60));
    if (run.status() == 0) break;  // it had just ended
    EXPECT_EQ(run.status(), 128 + signal) << Slurp(log);
    ASSERT_LT(interrupted, 60);
  }
  EXPECT_GT(interrupted, 3);
  auto expected = FilesOf(folder / "whole"), found = FilesOf(out);
  ExpectSameFiles(expected, found, "after " + std::to_string(interrupted) + " interruptions");
}

TEST(BlocksCommand, NameAFileThatTheyMissOrThatIsEmpty) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const auto arguments = InBlocks(out, {"--quiet", "--resume"}, 20000);
  BackgroundCommand run(arguments, folder / "log");
  // A view of block 1 in which block 2 is seen: which are some depends on rounding.
  std::string view;
  const auto trains_blocks = [&] {
    for (int v = 0; v < 30; ++v) {
      view = std::to_string(v);
      if (fs::exists(out + "/blocks/1/" + view + ".target.rgba") &&
          fs::exists(out + "/blocks/2/" + view + ".rgba"))
        return true;
    }
    return false;
  };
  for (int i = 0; i < 300000 && !trains_blocks(); ++i) usleep(1000);  // a sanitizer's build is slow
  ASSERT_TRUE(trains_blocks());
  run.Signal(SIGTERM);
  ASSERT_TRUE(run.EndsWithin(60));
  const auto expect_error = [&](const std::string& part) {
    const CommandResult resumed = Cosplat(arguments);
    EXPECT_EQ(resumed.code, 2);
    EXPECT_NE(resumed.err.find(part), std::string::npos) << resumed.err;
    EXPECT_EQ(resumed.err.find('\n'), resumed.err.size() - 1) << resumed.err;
    EXPECT_TRUE(fs::exists(out + "/checkpoint.bin"));
  };
  const std::string layer = out + "/blocks/2/" + view + ".rgba";
  fs::resize_file(layer, 0);
  expect_error(layer + ": has 0 bytes");
  fs::remove_all(out + "/blocks");
  expect_error(out + "/blocks/");
}

TEST(BlocksCommand, RefuseWhatNeedsTheWholeScene) {
  const TemporaryFolder folder;
  const std::vector<std::vector<std::string>> wrong{{"--prune", "dcsharp"},
                                                    {"--prune-to", "100"},
                                                    {"--budget", "auto"},
                                                    {"--drop-bands", "1"},
                                                    {"--preset", "3dgs"},
                                                    {"--save_iterations", "100"},
                                                    {"--test_iterations", "100"}};
  for (const auto& more : wrong) {
    const CommandResult refused = Cosplat(InBlocks(folder / "out", more));
    EXPECT_EQ(refused.code, 2) << more[0];
    EXPECT_NE(refused.err.find(more[0]), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("not with --blocks 3"), std::string::npos) << refused.err;
    EXPECT_EQ(refused.err.find('\n'), refused.err.size() - 1) << refused.err;
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
  // More blocks than Gaussians: found once there are some.
  const CommandResult many =
      Cosplat(MadeSceneTraining(folder / "many", 60, 40, {"--blocks", "500", "--quiet"}));
  EXPECT_EQ(many.code, 2);
  EXPECT_NE(many.err.find("--blocks 500"), std::string::npos) << many.err;
}

}  // namespace
}  // namespace cosplat::test

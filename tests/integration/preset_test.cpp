// `cosplat train-avatar --preset`: what the release's rule trains is saved, said and played.
#include <gtest/gtest.h>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

CommandResult TrainReleased(const std::string& out, const std::vector<std::string>& more) {
  const Workshop& made = Workshop::Get();
  std::vector<std::string> arguments{"train-avatar",
                                     "-s",
                                     made.head,
                                     "--flame",
                                     made.model,
                                     "-m",
                                     out,
                                     "--iterations",
                                     "20",
                                     "--eval",
                                     "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return Cosplat(arguments);
}

TEST(Preset, WhatTheReleaseTrainsIsPlayedByItsRule) {
  const TemporaryFolder folder;
  const std::string out = folder / "out", images = folder / "images";
  const std::vector<std::string> released{
      "--preset", "splatting-avatar-released", "--gaussians", "800"};
  ASSERT_EQ(TrainReleased(out, released).code, 0);
  EXPECT_EQ(ReadJson(out + "/run.json")["preset"], "splatting-avatar-released");
  EXPECT_EQ(ReadJson(out + "/run.json")["degree"], 0);
  const CommandResult info = Cosplat({"info", out + "/avatar.glb"});
  EXPECT_NE(info.out.find("SplattingAvatar's released code"), std::string::npos) << info.out;
  // The player, from the file, draws what the trainer drew at its end.
  ASSERT_EQ(Cosplat({"render", "-m", out, "-o", images, "--quiet"}).code, 0);
  EXPECT_EQ(Slurp(images + "/00000.png"), Slurp(out + "/test/ours_20/renders/00000.png"));
  // Its configuration repeats the run.
  const std::string again = folder / "again";
  ASSERT_EQ(Cosplat({"--config", out + "/config.ini", "train-avatar", "-m", again}).code, 0);
  EXPECT_EQ(Slurp(again + "/avatar.glb"), Slurp(out + "/avatar.glb"));
}

TEST(Preset, TheReleaseAndRefinedTracksAreOneLine) {
  const TemporaryFolder folder;
  const CommandResult refused =
      TrainReleased(folder / "out", {"--preset", "splatting-avatar-released", "--refine-track"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--refine-track"), std::string::npos);
  EXPECT_EQ(refused.err.find('\n'), refused.err.size() - 1) << refused.err;
}

}  // namespace
}  // namespace cosplat::test

// What commands say of their options, and of what a quality sets.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/base/json.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Help, HelpAndVersionSucceed) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--help"}, {"--version"}, {"train-avatar", "--help"}, {"render", "--help"}}) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 0);
    EXPECT_NE(result.out, "");
    EXPECT_EQ(result.err, "");
  }
}

// On one screen; the rest, with ranges, by --help-all.
TEST(Help, TheTrainersHelpIsShortUnlessAllIsAsked) {
  for (const std::string command : {"train-avatar", "avatar", "train-scene", "scene"}) {
    const std::string help = Cosplat({command, "--help"}).out;
    const std::string all = Cosplat({command, "--help-all"}).out;
    EXPECT_LE(std::count(help.begin(), help.end(), '\n'), 45) << help;
    EXPECT_TRUE(Has(help, "--quality {draft,standard,best}")) << help;
    EXPECT_TRUE(Has(help, " more options: --help-all")) << help;
    EXPECT_FALSE(Has(help, "--rotation_lr")) << help;
    EXPECT_TRUE(Has(all, "--rotation_lr")) << all;
    EXPECT_TRUE(Has(all, "--quality")) << all;
    EXPECT_TRUE(Has(all, "[1 - 10000000]")) << all;
  }
}

TEST(Help, AQualitySaysWhatItSets) {
  const TemporaryFolder folder;
  const CommandResult run = Cosplat({"train-scene",
                                     "-s",
                                     Workshop::Get().photos,
                                     "-m",
                                     folder / "out",
                                     "-r",
                                     "8",
                                     "--random-points",
                                     "50",
                                     "--quality",
                                     "draft"});
  ASSERT_EQ(run.code, 3) << run.err;  // so small, the photographs are nearly of one colour
  EXPECT_TRUE(Has(run.out, "--quality sets --iterations 2000\n")) << run.out;
  EXPECT_EQ(ReadJson(folder / "out/run.json")["iterations"], 2000);
}

}  // namespace
}  // namespace cosplat::test

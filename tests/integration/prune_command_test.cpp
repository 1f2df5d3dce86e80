// --prune, --prune-to and --budget auto from end to end.
#include <gtest/gtest.h>

#include "splat/base/json.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

class PruneCommand : public testing::Test {
 protected:
  CommandResult TrainScene(const std::string& out, const std::vector<std::string>& more) const {
    return TrainMadeScene(folder_ / out, 150, 400, more);
  }
  void ExpectBadScene(const std::vector<std::string>& more, const std::string& why) const {
    const CommandResult result = TrainScene("bad", more);
    EXPECT_EQ(result.code, 2);
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
    EXPECT_FALSE(fs::exists(folder_ / "bad"));  // nothing half-written
  }
  double GaussiansOf(const std::string& out) const {
    const std::string path = folder_ / (out + "/stats.json");
    const Json json = ReadJson(path);
    return JsonField(path, json)["gaussians"].Number();
  }

  TemporaryFolder folder_;
};

TEST_F(PruneCommand, ACountAloneIsKeptByLeavingOut) {
  const CommandResult result = TrainScene("out", {"--prune-to", "100"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out.find("--prune-to 100: "), std::string::npos) << result.out;
  EXPECT_NEAR(GaussiansOf("out"), 100, 3);
}

TEST_F(PruneCommand, BudgetAutoKeepsWhatTheImagesNeed) {
  double last = 1e9;
  for (const char* tolerance : {"0.05", "2"}) {
    const CommandResult result =
        TrainScene("out", {"--overwrite", "--budget", "auto", "--tolerance", tolerance});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.out.find("pruned: "), std::string::npos) << result.out;
    EXPECT_NE(result.out.find(" Gaussians by leave-one-out"), std::string::npos) << result.out;
    EXPECT_LT(GaussiansOf("out"), last);
    last = GaussiansOf("out");
  }
}

TEST_F(PruneCommand, WhatDoesNotFitIsAnError) {
  ExpectBadScene({"--prune", "dcsharp-triangle"}, "needs triangles");
  ExpectBadScene({"--prune", "lp", "--prune-to", "100"}, "does not support a target count");
  ExpectBadScene({"--prune", "opacity", "--prune-lambda", "1"}, "does not learn a mask");
  ExpectBadScene({"--budget", "auto", "--prune-to", "100"}, "--budget auto finds the count");
  ExpectBadScene({"--budget", "auto", "--prune", "opacity"}, "prunes by leave-one-out");
  ExpectBadScene({"--tolerance", "1"}, "--tolerance: is of --budget auto");
  ExpectBadScene({"--tolerance", "1", "--prune-to", "100"}, "is of --budget auto");
}

TEST_F(PruneCommand, RulesOfTheStudyAreKnownByName) {
  const std::string config = folder_ / "config.ini";
  std::ofstream(config) << "train-scene.prune=\"compact\"\n";
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--prune", "compact"}, {"--config", config}})
    ExpectBadScene(more, "cosplat: --prune compact: only cosplat-study has this rule");
  for (const std::string rule : {"dcsharp-released", "lightgaussian", "speedy", "random"})
    ExpectBadScene({"--prune", rule}, "--prune " + rule + ": only cosplat-study");
  ExpectBadScene({"--prune", "best"}, "'best' is not a pruning rule; known: none, leave-one-out");
}

TEST_F(PruneCommand, AvatarsPruneByTriangleAndFindTheirBudget) {
  const auto train = [&](const std::string& out, const std::vector<std::string>& more) {
    return TrainMadeAvatar(folder_ / out, 60, 1500, more);
  };
  const CommandResult capped =
      train("capped", {"--triangle-cap", "1", "--densification_interval", "10"});
  EXPECT_NE(capped.out.find(" Gaussians by --triangle-cap"), std::string::npos) << capped.out;
  const CommandResult bare =
      train("triangle", {"--prune", "dcsharp-triangle", "--prune-to", "100"});
  ASSERT_EQ(bare.code, 0) << bare.err;
  EXPECT_NE(bare.out.find("--prune-to 100: "), std::string::npos) << bare.out;
  EXPECT_GE(GaussiansOf("triangle"), 100);  // none of its triangles is left bare
  EXPECT_LT(GaussiansOf("triangle"), 1500);
  const CommandResult budget = train("budget", {"--budget", "auto", "--tolerance", "3"});
  ASSERT_EQ(budget.code, 0) << budget.err;
  EXPECT_LT(GaussiansOf("budget"), 1500);
  EXPECT_TRUE(fs::exists(folder_ / "budget/avatar.glb"));
}

}  // namespace
}  // namespace cosplat::test

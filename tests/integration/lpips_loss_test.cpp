// `--lambda_lpips` and `--lpips` of the trainers as a user gives them.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/command.h"
#include "tests/support/tiny_onnx.h"

namespace cosplat::test {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class LpipsLossCommand : public testing::Test {
 protected:
  LpipsLossCommand() {
    WriteReluLpips(net_, "small");
    WriteBallScene(photos_, 6);
  }
  CommandResult Train(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{
        "train-scene", "-s", photos_, "-m", folder_ / name, "--eval", "--iterations", "40"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments);
  }
  std::string Splats(const std::string& name) const {
    return Slurp(folder_ / name + "/point_cloud/iteration_40/point_cloud.ply");
  }
  void ExpectRefused(const std::vector<std::string>& more,
                     const std::vector<std::string>& parts) const {
    const CommandResult result = Train("refused", more);
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& part : parts)
      EXPECT_TRUE(Contains(result.err, part)) << result.err << " lacks " << part;
  }
  const TemporaryFolder folder_;
  const std::string net_ = folder_ / "net", photos_ = folder_ / "photos";
};

TEST_F(LpipsLossCommand, IsTrainedMeasuredAndRepeated) {
  const std::vector<std::string> options{
      "--lpips", net_, "--lambda_lpips", "0.5", "--lpips-crop", "16"};
  const CommandResult trained = Train("with", options);
  ASSERT_EQ(trained.code, 0) << trained.err;
  EXPECT_TRUE(Contains(trained.out, "  LPIPS (small) 0.")) << trained.out;
  EXPECT_GT(ReadJson(folder_ / "with/results.json")["ours_40"]["LPIPS_small"], 0);
  const std::string config = folder_ / "with/config.ini";
  ASSERT_EQ(Cosplat({"train-scene", "--config", config, "-m", folder_ / "again"}).code, 0);
  EXPECT_EQ(Splats("again"), Splats("with"));
}

// A network alone is measured with, and changes no training.
TEST_F(LpipsLossCommand, IsOffByDefault) {
  const CommandResult measured = Train("measured", {"--lpips", net_});
  ASSERT_EQ(measured.code, 0) << measured.err;
  EXPECT_TRUE(Contains(measured.out, "LPIPS (small)"));
  const CommandResult plain = Train("plain", {});
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_FALSE(Contains(plain.out, "LPIPS"));
  EXPECT_EQ(Splats("measured"), Splats("plain"));
  ASSERT_EQ(Train("with", {"--lpips", net_, "--lambda_lpips", "0.5"}).code, 0);
  EXPECT_NE(Splats("with"), Splats("plain"));
}

TEST_F(LpipsLossCommand, BadInputIsOneLine) {
  ExpectRefused({"--lambda_lpips", "0.1"}, {"--lambda_lpips", "--lpips DIR"});
  const std::string absent = folder_ / "absent";
  ExpectRefused({"--lambda_lpips", "0.1", "--lpips", absent}, {absent, "_backbone.onnx"});
  ExpectRefused({"--lambda_lpips", "0.1", "--lpips", net_, "--lpips-crop", "5"},
                {"crops of at least 6x6", "5"});
  OnnxParts parts;
  parts.nodes = {OnnxNode("Sigmoid", {"image"}, "out")};
  parts.outputs = {{"out", 3}};
  std::ofstream(net_ + "/small_backbone.onnx", std::ios::binary) << OnnxBytes(parts);
  ExpectRefused({"--lambda_lpips", "0.1", "--lpips", net_},
                {"small_backbone.onnx", "node_out (Sigmoid)", "not among the layers"});
}

TEST_F(LpipsLossCommand, APresetSaysThatItLeavesItOut) {
  const std::string head = folder_ / "head";
  ASSERT_EQ(Cosplat({"make-head",
                     "-o",
                     head,
                     "--frames",
                     "4",
                     "--test-frames",
                     "1",
                     "--size",
                     "48",
                     "--quiet"})
                .code,
            0);
  std::vector<std::string> arguments{"train-avatar",
                                     "-s",
                                     head,
                                     "--flame",
                                     head + "/model.npz",
                                     "-m",
                                     folder_ / "avatar",
                                     "--iterations",
                                     "3",
                                     "--gaussians",
                                     "200",
                                     "--preset",
                                     "splatting-avatar"};
  const CommandResult without = Cosplat(arguments);
  ASSERT_EQ(without.code, 0) << without.err;
  EXPECT_TRUE(Contains(without.out, "without its LPIPS loss")) << without.out;
  const std::string file = folder_ / "avatar/avatar.glb", first = Slurp(file);
  arguments.insert(arguments.end(), {"--lpips", net_, "--overwrite"});
  const CommandResult with = Cosplat(arguments);
  ASSERT_EQ(with.code, 0) << with.err;
  EXPECT_FALSE(Contains(with.out, "without its LPIPS loss"));
  EXPECT_NE(Slurp(file), first);
}

}  // namespace
}  // namespace cosplat::test

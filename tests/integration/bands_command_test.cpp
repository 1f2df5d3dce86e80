// --drop-bands from end to end: what is said of it, and that files hold what was trained.
#include <gtest/gtest.h>

#include "splat/io/splat_file.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

class BandsCommand : public testing::Test {
 protected:
  std::vector<std::string> Scene(const std::string& out) const {
    return {"train-scene",
            "-s",
            Workshop::Get().photos,
            "-m",
            folder_ / out,
            "--iterations",
            "60",
            "--eval",
            "--random-points",
            "300"};
  }
  std::vector<std::string> Avatar(const std::string& out) const {
    return {"train-avatar",
            "-s",
            Workshop::Get().head,
            "--flame",
            Workshop::Get().model,
            "-m",
            folder_ / out,
            "--iterations",
            "30",
            "--gaussians",
            "500",
            "--eval"};
  }
  static CommandResult With(std::vector<std::string> arguments, const std::string& levels) {
    arguments.insert(arguments.end(), {"--drop-bands", levels});
    return Cosplat(arguments);
  }
  const TemporaryFolder folder_;
};

void ExpectSays(const CommandResult& result, const std::string& part) {
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
}

// Dropped, told, and drawn from the file as in training.
void ExpectDropped(const CommandResult& trained,
                   const std::string& folder,
                   const std::string& iterations) {
  ExpectSays(trained, "bands dropped: mean degree ");
  const Json stats = ReadJson(folder + "/stats.json");
  EXPECT_GT(stats["rest_saved"], 0.05);
  EXPECT_TRUE(stats["drop_psnr"].is_number());
  double gaussians = 0, degrees = 0;
  for (size_t degree = 0; degree < stats["degrees"].size(); ++degree) {
    gaussians += stats["degrees"][degree].get<double>();
    degrees += double(degree) * stats["degrees"][degree].get<double>();
  }
  EXPECT_EQ(gaussians, stats["gaussians"]);
  EXPECT_NEAR(degrees / gaussians, stats["mean_degree"].get<double>(), 1e-9);
  ExpectSays(Cosplat({"info", folder}), "bands dropped: mean degree ");
  EXPECT_EQ(Cosplat({"report", "-m", folder, "--quiet"}).code, 0);
  EXPECT_NE(Slurp(folder + "/report.html").find("Coefficients dropped"), std::string::npos);
  const std::string image = folder + "/test/ours_" + iterations + "/renders/00000.png";
  const Image8 before = ReadImage(image);
  EXPECT_EQ(Cosplat({"render", "-m", folder, "--quiet"}).code, 0);
  const Image8 after = ReadImage(image);
  ASSERT_EQ(before.data.size(), after.data.size());
  int max = 0;
  for (size_t i = 0; i < after.data.size(); ++i)
    max = std::max(max, std::abs(int(before.data[i]) - int(after.data[i])));
  EXPECT_LE(max, 1);  // of 255, where rounding turns over
}

TEST_F(BandsCommand, AScene) {
  ExpectDropped(With(Scene("scene"), "4"), folder_ / "scene", "60");
  const std::string ply = folder_ / "scene/point_cloud/iteration_60/point_cloud.ply";
  ExpectSays(Cosplat({"info", ply}), "own degrees: ");
  const std::string file = folder_ / "scene.glb";
  EXPECT_EQ(Cosplat({"export", "-m", folder_ / "scene", "--glb", file, "--quiet"}).code, 0);
  EXPECT_EQ(ReadSplats(file).degrees, ReadSplats(ply).degrees);
}

TEST_F(BandsCommand, AnAvatar) {
  ExpectDropped(With(Avatar("avatar"), "4"), folder_ / "avatar", "30");
}

TEST_F(BandsCommand, NothingIsSaidWhereNoneIsDropped) {
  const CommandResult trained = With(Scene("scene"), "0");
  EXPECT_EQ(trained.code, 0) << trained.err;
  EXPECT_EQ(trained.out.find("bands"), std::string::npos) << trained.out;
  EXPECT_EQ(ReadJson(folder_ / "scene/stats.json")["rest_saved"], 0);
  EXPECT_EQ(Cosplat({"info", folder_ / "scene"}).out.find("bands"), std::string::npos);
}

TEST_F(BandsCommand, WhatIsNoThresholdIsRefused) {
  for (const char* bad : {"-1", "nan", "some"}) {
    const CommandResult trained = With(Scene("scene"), bad);
    EXPECT_NE(trained.code, 0);
    EXPECT_NE(trained.err.find("--drop-bands"), std::string::npos) << trained.err;
  }
}

}  // namespace
}  // namespace cosplat::test

// --basis and --rest-lr from end to end; runs whose colours no file can hold.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

class BasisCommand : public testing::Test {
 protected:
  CommandResult TrainScene(const std::string& out, const std::vector<std::string>& more) const {
    return TrainMadeScene(folder_ / out, 60, 300, more);
  }
  CommandResult TrainAvatar(const std::string& out, const std::vector<std::string>& more) const {
    return TrainMadeAvatar(folder_ / out, 20, 500, more);
  }
  // Trained and judged, and one line says why it is not saved.
  void ExpectNotSaved(const CommandResult& trained, const std::string& folder) const {
    EXPECT_EQ(trained.code, 0) << trained.err;
    const std::string why = "no splats will be saved: dcsh-literal is not spherical harmonics";
    const size_t at = trained.out.find(why);
    ASSERT_NE(at, std::string::npos) << trained.out;
    EXPECT_EQ(trained.out.find(why, at + 1), std::string::npos);
    EXPECT_FALSE(fs::exists(folder + "/point_cloud"));
    EXPECT_FALSE(fs::exists(folder + "/avatar.glb"));
    EXPECT_TRUE(fs::exists(folder + "/results.json"));
    EXPECT_EQ(Cosplat({"metrics", "-m", folder}).code, 0);
    EXPECT_EQ(Cosplat({"report", "-m", folder, "--quiet"}).code, 0);
    const CommandResult rendered = Cosplat({"render", "-m", folder});
    EXPECT_EQ(rendered.code, 2);
    for (const char* part : {"run.json: basis", "dcsh-literal", "not spherical harmonics"})
      EXPECT_NE(rendered.err.find(part), std::string::npos) << rendered.err;
    EXPECT_EQ(std::count(rendered.err.begin(), rendered.err.end(), '\n'), 1) << rendered.err;
  }

  const TemporaryFolder folder_;
};

TEST_F(BasisCommand, ASceneOfTheLiteralBasisIsJudgedButNotSaved) {
  ExpectNotSaved(TrainScene("scene", {"--basis", "dcsh-literal", "--save_iterations", "30"}),
                 folder_ / "scene");
}

TEST_F(BasisCommand, AnAvatarOfTheLiteralBasisIsJudgedButNotSaved) {
  ExpectNotSaved(TrainAvatar("avatar", {"--basis", "dcsh-literal", "--refine-track"}),
                 folder_ / "avatar");
  EXPECT_TRUE(fs::exists(folder_ / "avatar/refined_track.json"));
}

// Its colours are constant, which every basis can express.
TEST_F(BasisCommand, OfDegreeZeroItIsSaved) {
  EXPECT_EQ(TrainScene("scene", {"--basis", "dcsh-literal", "--sh_degree", "0", "--quiet"}).code,
            0);
  EXPECT_TRUE(fs::exists(folder_ / "scene/point_cloud/iteration_60/point_cloud.ply"));
  const CommandResult trained =
      TrainAvatar("avatar", {"--basis", "dcsh-literal", "--sh_degree", "0", "--quiet"});
  EXPECT_EQ(trained.code, 0) << trained.err;
  const CommandResult rendered = Cosplat({"render", "-m", folder_ / "avatar", "--quiet"});
  EXPECT_EQ(rendered.code, 0) << rendered.err;
}

// What was trained in the released basis is drawn from its file as it was in training.
TEST_F(BasisCommand, WhatIsTrainedInTheReleasedBasisIsRenderedFromItsFile) {
  ASSERT_EQ(TrainScene("scene", {"--basis", "dcsh-released", "--quiet"}).code, 0);
  ASSERT_EQ(TrainAvatar("avatar", {"--basis", "dcsh-released", "--quiet"}).code, 0);
  for (const auto& [folder, iterations] :
       {std::pair{folder_ / "scene", "60"}, std::pair{folder_ / "avatar", "20"}}) {
    const std::string image =
        folder + "/test/ours_" + std::string(iterations) + "/renders/00000.png";
    const Image8 trained = ReadImage(image);
    const CommandResult rendered = Cosplat({"render", "-m", folder, "--quiet"});
    EXPECT_EQ(rendered.code, 0) << rendered.err;
    const Image8 read = ReadImage(image);
    ASSERT_EQ(trained.data.size(), read.data.size());
    int max = 0;
    for (size_t i = 0; i < read.data.size(); ++i)
      max = std::max(max, std::abs(int(trained.data[i]) - int(read.data[i])));
    EXPECT_LE(max, 1) << folder;  // of 255, where rounding turns over
  }
}

double Psnr(const std::string& folder) {
  return ReadJson(folder + "/results.json")["ours_60"]["PSNR"].get<double>();
}

TEST_F(BasisCommand, TheRestRateMakesShTrainAsDcshDoes) {
  ASSERT_EQ(TrainScene("dcsh", {"--quiet"}).code, 0);
  ASSERT_EQ(TrainScene("fast_sh", {"--basis", "sh", "--rest-lr", "1.772e-3", "--quiet"}).code, 0);
  ASSERT_EQ(TrainScene("sh", {"--basis", "sh", "--quiet"}).code, 0);
  // Measured: the same six digits, and 0.005 dB apart.
  const double dcsh = Psnr(folder_ / "dcsh");
  const double apart = std::abs(dcsh - Psnr(folder_ / "sh"));
  EXPECT_GT(apart, 1e-3);
  EXPECT_LT(std::abs(dcsh - Psnr(folder_ / "fast_sh")), 0.2 * apart);
}

}  // namespace
}  // namespace cosplat::test

// What `export`, `play`, `info`, `render` and `metrics` make of a point cloud of GaussianAvatars.
#include <gtest/gtest.h>

#include <algorithm>

#include "flame/model.h"
#include "tests/avatar/gaussian_avatars_fixture.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

// A point cloud on the workshop's head, as after 700 steps of theirs.
class BoundCloud : public testing::Test {
 protected:
  BoundCloud() : flame_(LoadFlameModel(Workshop::Get().model)) {
    fs::create_directories(cloud_);
    WriteBoundPly(ply_, RandomRows(4000, flame_.faces.size(), 1));
    FlameParamOf(SomeFrames(5, size_t(flame_.expression_count), 2),
                 std::vector<float>(size_t(flame_.shape_count), 0.2f),
                 size_t(flame_.expression_count),
                 size_t(flame_.vertex_count))
        .Write(cloud_ + "/flame_param.npz");
  }
  static std::string Run(const std::vector<std::string>& arguments) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.out;
  }
  static void Refuse(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& parts) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& part : parts)
      EXPECT_NE(result.err.find(part), std::string::npos) << result.err << " lacks " << part;
  }
  static void ExpectPart(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text << " lacks " << part;
  }
  std::string Played(const std::string& model, const std::string& name) {
    const std::string out = folder_ / name;
    Run({"play",
         model,
         "--flame",
         Workshop::Get().model,
         "--drive",
         cloud_ + "/flame_param.npz",
         "--headless",
         "--size",
         "80x80",
         "-o",
         out,
         "--quiet"});
    return Slurp(out + "/00003.png");
  }

  TemporaryFolder folder_;
  FlameModel flame_;
  std::string cloud_ = folder_ / "point_cloud/iteration_700", ply_ = cloud_ + "/point_cloud.ply";
};

TEST_F(BoundCloud, PlaysAsItIsAndAsTheAvatarThatItBecomes) {
  const std::string glb = folder_ / "a.glb";
  const std::string said =
      Run({"export", "--splats", ply_, "--flame", Workshop::Get().model, "--glb", glb});
  ExpectPart(said, "4,000 splats");
  ExpectPart(Run({"info", glb}), "GaussianAvatars' rule");
  ExpectPart(Run({"info", ply_}), "4000 Gaussians, SH degree 3");
  const std::string image = Played(ply_, "cloud");
  EXPECT_GT(image.size(), 500u);
  EXPECT_EQ(image, Played(glb, "avatar"));
}

TEST_F(BoundCloud, BecomesARunThatIsRenderedAndMeasured) {
  const Workshop& w = Workshop::Get();
  const std::string run = folder_ / "run";
  Run({"export", "--splats", ply_, "--flame", w.model, "-s", w.head, "--run", run});
  Run({"render", "-m", run, "--quiet"});
  ExpectPart(Run({"metrics", "-m", run}), "(3 views)");
  EXPECT_TRUE(fs::exists(run + "/test/ours_700/renders/00002.png"));
  Run({"render", "-m", run, "--orbit", "-o", folder_ / "orbit", "--quiet"});
  Run({"play", run, "--headless", "-o", folder_ / "played", "--quiet"});
  ExpectPart(Run({"info", run}), "trained avatar: 700 iterations");
}

TEST_F(BoundCloud, IsWrittenAtRest) {
  const std::string ply = folder_ / "rest.ply", spz = folder_ / "rest.spz";
  const std::string said = Run(
      {"export", "--splats", ply_, "--flame", Workshop::Get().model, "--ply", ply, "--spz", spz});
  ExpectPart(said, "the avatar at rest");
  ExpectPart(Run({"info", ply}), "3DGS splats: 4,000 Gaussians");
  ExpectPart(Run({"info", spz}), "SPZ splats: 4,000 Gaussians");
}

TEST_F(BoundCloud, SaysWhatIsMissing) {
  const Workshop& w = Workshop::Get();
  const std::string glb = folder_ / "a.glb";
  Refuse({"play", ply_, "--headless", "-o", folder_ / "x"}, {ply_, "--flame"});
  Refuse({"export", "--splats", ply_, "--glb", glb}, {ply_, "--flame"});
  Refuse({"export", "--splats", ply_, "--flame", w.model, "--run", folder_ / "run"},
         {"--run", "-s"});
  Refuse({"export", "-m", w.scene, "--run", folder_ / "run"}, {"--run", "GaussianAvatars"});
  fs::remove(cloud_ + "/flame_param.npz");
  Refuse({"export", "--splats", ply_, "--flame", w.model, "--glb", glb}, {"flame_param.npz"});
  EXPECT_FALSE(fs::exists(glb) || fs::exists(folder_ / "run"));
  ExpectPart(Run({"info", ply_}), "without");
}

}  // namespace
}  // namespace cosplat::test

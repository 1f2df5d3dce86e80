// How an avatar holds where it was not filmed: `metrics --turn`, figures by turn, `make-head
// --frontal`.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

const Workshop& Made() { return Workshop::Get(); }

// A run's avatar, copied.
class Turned : public testing::Test {
 protected:
  Turned() { fs::copy(Made().avatar, run_, fs::copy_options::recursive); }
  // The sheet of the run as it is now.
  Image8 Sheet() const {
    const CommandResult result = Cosplat({"metrics", "-m", run_, "--turn"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.out.find("alpha outside of the head: 0 deg 0."), std::string::npos)
        << result.out;
    EXPECT_NE(result.out.find("180 deg"), std::string::npos) << result.out;
    return ReadImage(run_ + "/turned.png");
  }

  TemporaryFolder folder_;
  std::string run_ = folder_ / "run";
};

TEST_F(Turned, IsDrawnFromAllAroundAndReported) {
  EXPECT_EQ(Sheet().width, 6 * 320);
  EXPECT_EQ(Cosplat({"report", "-m", run_}).code, 0);
  EXPECT_NE(Slurp(run_ + "/report.html").find("not filmed"), std::string::npos);
  const CommandResult scene = Cosplat({"metrics", "-m", Made().scene, "--turn"});
  EXPECT_EQ(scene.code, 2);
  EXPECT_NE(scene.err.find("is for avatars"), std::string::npos) << scene.err;
}

// Several cameras: the first one may stand aside, and 0 degrees is still before the face.
TEST_F(Turned, IsCountedFromTheFace) {
  const Image8 expected = Sheet();
  Json run = ReadJson(run_ + "/run.json");
  run["reference"]["rotation"][1] = run["reference"]["rotation"][1].get<double>() + 0.8;
  std::ofstream(run_ + "/run.json") << run.dump();
  const Image8 sheet = Sheet();
  double error = 0;
  for (size_t i = 0; i < sheet.data.size(); ++i)
    error += std::abs(int(sheet.data[i]) - int(expected.data[i])) / double(sheet.data.size());
  EXPECT_LT(error, 5);  // of 255; measured: 2.3, and 20 if angles were counted from the camera
}

// Of a square of larger frames.
TEST_F(Turned, ShowsTheHeadInTheMiddle) {
  const Image8 expected = Sheet();
  Json run = ReadJson(run_ + "/run.json");
  Json& intrinsics = run["reference"]["camera"]["intrinsics"];
  for (const size_t i : {2, 3}) intrinsics[i] = intrinsics[i].get<double>() * 1.8;
  std::ofstream(run_ + "/run.json") << run.dump();
  EXPECT_EQ(Sheet().data, expected.data);
}

TEST(TurnedFigures, AreGivenByHowFarTheHeadIsTurned) {
  const TemporaryFolder folder;
  const CommandResult head = Cosplat({"make-head",
                                      "-o",
                                      folder / "head",
                                      "--frontal",
                                      "--frames",
                                      "20",
                                      "--test-frames",
                                      "12",
                                      "--size",
                                      "64",
                                      "--quiet"});
  ASSERT_EQ(head.code, 0) << head.err;
  const CommandResult train = Cosplat({"train-avatar",
                                       "-s",
                                       folder / "head",
                                       "--flame",
                                       folder / "head/model.npz",
                                       "-m",
                                       folder / "run",
                                       "--eval",
                                       "--iterations",
                                       "20",
                                       "--gaussians",
                                       "500",
                                       "--quiet"});
  ASSERT_EQ(train.code, 0) << train.err;
  const CommandResult metrics = Cosplat({"metrics", "-m", folder / "run"});
  EXPECT_EQ(metrics.code, 0) << metrics.err;
  for (const std::string limit : {"22", "38", "52", "75", "135", "180"})
    EXPECT_NE(metrics.out.find("turned to " + limit + " deg"), std::string::npos) << metrics.out;
}

}  // namespace
}  // namespace cosplat::test

// A scene packed for a bare machine, and the benchmark that trains on it there.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "splat/base/files.h"
#include "splat/base/json.h"
#include "tests/gpu/packed_scene.h"
#include "tests/gpu/scene_times.h"
#include "tests/parity/device_fixture.h"
#include "tests/parity/training_run.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

class SceneBench : public test::DeviceTest {};

TEST_F(SceneBench, TrainsAndTellsItsFigures) {
  const test::TemporaryFolder folder;
  TrainingScene scene;
  scene.train = test::TrainingRun::Frames(true);
  scene.test = {scene.train[1]};
  scene.renderings = true;
  const Gaussians truth = test::TrueScene(1, 20);
  for (size_t i = 0; i < truth.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      scene.points.push_back(truth.at(kPosition, i)[k]);
      scene.point_colors.push_back(128);
    }
  WriteFileAtomically(folder / "scene",
                      [&](std::ostream& out) { test::WritePackedScene(out, scene); });
  const std::string out = folder / "figures.json";
  test::RunSceneBench({folder / "scene", "--out", out, "--iterations", "30", "--prune-to", "12"});
  const Json json = ReadJson(out);
  EXPECT_EQ(json["iterations"], 30);
  EXPECT_EQ(json["prune_to"], 12);
  EXPECT_EQ(json["gaussians"], 12);
  EXPECT_EQ(json["views"], 1);
  EXPECT_GT(double(json["seconds"]), 0);
  EXPECT_GT(double(json["psnr"]), 10);
  EXPECT_GT(double(json["ssim"]), 0.3);
}

// As renderings come.
TEST_F(SceneBench, FindsPointsWhereThereAreNone) {
  const test::TemporaryFolder folder;
  TrainingScene scene;
  scene.train = test::TrainingRun::Frames(true);
  scene.test = {scene.train[1]};
  scene.renderings = true;
  WriteFileAtomically(folder / "scene",
                      [&](std::ostream& out) { test::WritePackedScene(out, scene); });
  const std::string out = folder / "figures.json";
  test::RunSceneBench({folder / "scene", "--out", out, "--iterations", "2"});
  EXPECT_GT(int(ReadJson(out)["gaussians"]), 1000);
}

TEST_F(SceneBench, RefusesWhatItDoesNotKnow) {
  test::ExpectError([] { test::RunSceneBench({}); }, {"FILE"});
  test::ExpectError([] { test::RunSceneBench({"scene"}); }, {"--out"});
  test::ExpectError([] { test::RunSceneBench({"scene", "--out"}); }, {"--out", "lacks"});
  test::ExpectError([] { test::RunSceneBench({"scene", "--fast"}); }, {"--fast"});
  test::ExpectError([] { test::RunSceneBench({"scene", "--iterations", "3x"}); }, {"'3x'"});
  test::ExpectError(
      [] {
        test::RunSceneBench({"/nowhere/scene", "--out", "f"});
      },
      {"/nowhere/scene", "cannot be read"});
}

}  // namespace
}  // namespace cosplat

// `cosplat check` and --strict: exit codes and what they print.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/integration/command.h"
#include "tests/street/nerf_scene.h"

namespace cosplat::test {
namespace {

struct Scenes {
  NerfScene good{24}, bad{24};
  Scenes() {
    good.WritePoints("points3D.ply");
    bad.WritePoints("points3D.ply");
    bad.json["fl_x"] = bad.json["fl_y"] = 2 * NerfScene::kFocal;
    good.Load();  // writes transforms.json
    bad.Load();
  }
};

TEST(CheckCommand, SaysByItsExitCode) {
  const Scenes scenes;
  const CommandResult good = Cosplat({"check", scenes.good.folder.path()});
  EXPECT_EQ(good.code, 0) << good.out << good.err;
  EXPECT_NE(good.out.find("tells one story"), std::string::npos) << good.out;
  const CommandResult bad = Cosplat({"check", scenes.bad.folder.path()});
  EXPECT_EQ(bad.code, 3) << bad.out << bad.err;
  EXPECT_NE(bad.out.find("WRONG: "), std::string::npos) << bad.out;
  EXPECT_EQ(Cosplat({"check", scenes.bad.folder / "none"}).code, 2);
}

TEST(CheckCommand, TrainingSaysItByItsExitCodeToo) {
  const Scenes scenes;
  const auto train = [&](const TemporaryFolder& out, const char* option) {
    return Cosplat({"train-scene",
                    "-s",
                    scenes.bad.folder.path(),
                    "-m",
                    out / "run",
                    "--iterations",
                    "2",
                    option});
  };
  const TemporaryFolder out, other;
  const CommandResult trained = train(out, "--quiet");
  EXPECT_EQ(trained.code, 3) << trained.err;
  EXPECT_NE(trained.err.find("WRONG: "), std::string::npos) << trained.err;
  EXPECT_NE(trained.err.find("the results are of data that is WRONG"), std::string::npos)
      << trained.err;
  EXPECT_TRUE(std::filesystem::exists(out / "run/point_cloud/iteration_2/point_cloud.ply"));
  // And later, when it has nothing to do.
  EXPECT_EQ(train(out, "--resume").code, 3);
  const CommandResult refused = train(other, "--strict");
  EXPECT_EQ(refused.code, 2) << refused.err;
  EXPECT_NE(refused.err.find("--strict refuses it"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace cosplat::test

// Runs of 3DGS's code, and head models as people have them.
#include <gtest/gtest.h>

#include <fstream>

#include "apps/cosplat/run/run_folder.h"
#include "flame/model.h"
#include "flame/track.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

void Write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

TEST(Runs, Of3dgsAreReadByTheirArguments) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "point_cloud/iteration_7000");
  std::filesystem::create_directories(folder / "point_cloud/iteration_30000");
  Write(folder / "cfg_args",
        "Namespace(sh_degree=2, source_path='/data/it\\'s here, (1)', model_path=\"./out\", "
        "images='images_4', depths='', test_iterations=[7000, 30000], resolution=-1, "
        "white_background=True, eval=True)");
  const Json run = RunOfCfgArgs(folder.path());
  EXPECT_EQ(run["source"], "/data/it's here, (1)");
  EXPECT_EQ(run["iterations"], 30000);
  EXPECT_EQ(run["degree"], 2);
  EXPECT_EQ(run["background"], Json({1.0f, 1.0f, 1.0f}));
  EXPECT_EQ(run["split"]["resolution"], 4);
  EXPECT_EQ(run["split"]["eval"], true);
  Write(folder / "cfg_args", "Namespace(sh_degree=3)");
  ExpectError([&] { RunOfCfgArgs(folder.path()); }, {"cfg_args", "source_path"});
  Write(folder / "cfg_args", "{}");
  ExpectError([&] { RunOfCfgArgs(folder.path()); }, {"cfg_args", "Namespace"});
}

TEST(HeadModels, AreNamedForWhatTheyAre) {
  const TemporaryFolder folder;
  const auto expect = [&](const char* name, const std::string& content, const char* what) {
    Write(folder / name, content);
    ExpectError([&] { LoadFlameModel(folder / name); }, {name, what});
  };
  expect("a.pkl", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "git lfs pull");
  expect("b.npz", "<!DOCTYPE html><html><head><title>Sign in</title>", "web page");
  expect("landmark_embedding.npy", "\x93NUMPY\x01\x00v", "one NumPy array");
  expect("c.pkl", std::string("PK\x03\x04") + std::string(100, '\0'), "ZIP archive");
  expect("d.pkl", "", "empty");
  std::string pickle = "\x80\x02";
  for (int i = 0; i < 2000; ++i) pickle += "ab\r\n";
  expect("e.pkl", pickle, "download it again as a binary file");
  expect("F.PKL", "\x80\x02N.", "not a FLAME model");  // read, not refused for its name
}

TEST(HeadModels, SayWhatIsLostOfExpressions) {
  FlameModel flame;
  FlameParams face;
  face.expression = {1, 2};
  flame.expression_count = 2;
  EXPECT_EQ(UnusedExpressions(flame, {&face}), "");
  flame.expression_count = 1;
  const std::string line = UnusedExpressions(flame, {&face});
  EXPECT_NE(line.find("1 of 2 expression coefficients"), std::string::npos) << line;
  EXPECT_NE(line.find("80 %"), std::string::npos) << line;
}

}  // namespace
}  // namespace cosplat::test

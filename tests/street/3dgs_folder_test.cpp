// The commands on a folder that 3DGS's own code wrote: cfg_args, cameras.json, input.ply and
// point_cloud/, on COLMAP's layout with reduced images only.
#include "tests/integration/command.h"
#include "tests/street/nerf_scene.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

constexpr int kViews = 9;

// COLMAP's text form of NerfScene's plane, at twice the size of the images in `images`.
void WriteColmapScene(const std::string& folder, const std::string& images) {
  fs::create_directories(folder + "/sparse/0");
  fs::create_directories(folder + "/" + images);
  std::ofstream(folder + "/sparse/0/cameras.txt")
      << "1 PINHOLE " << 2 * NerfScene::kWidth << ' ' << 2 * NerfScene::kHeight << ' '
      << 2 * NerfScene::kFocal << ' ' << 2 * NerfScene::kFocal << ' ' << NerfScene::kWidth << ' '
      << NerfScene::kHeight << '\n';
  std::ofstream list(folder + "/sparse/0/images.txt");
  for (int i = 0; i < kViews; ++i) {
    const double x = 0.1 * (i - kViews / 2), y = 0.05 * (i % 3);
    const std::string name = std::to_string(i) + ".png";
    WriteImage(folder + "/" + images + "/" + name, NerfScene::Photograph(x, y));
    list << i + 1 << " 1 0 0 0 " << -x << ' ' << -y << " 0 1 " << name << "\n\n";
  }
  std::ofstream points(folder + "/sparse/0/points3D.txt");
  for (int i = 0; i < 400; ++i) {
    const double x = 0.1 * (i % 20 - 9.5), y = 0.08 * (i / 20 - 9.5);
    const auto c = PlaneColor(x, y);
    points << i + 1 << ' ' << x << ' ' << y << " 3 " << int(c[0]) << ' ' << int(c[1]) << ' '
           << int(c[2]) << " 0.5 1 0 2 0\n";
  }
}

CommandResult Trained(const std::string& data, const std::string& run, const char* images) {
  return Cosplat({"train-scene",
                  "-s",
                  data,
                  "-m",
                  run,
                  "-i",
                  images,
                  "--iterations",
                  "60",
                  "--eval",
                  "--basis",
                  "sh",
                  "--quiet"});
}

TEST(FolderOf3dgs, ServesEveryCommand) {
  const TemporaryFolder folder;
  WriteColmapScene(folder / "data", "images_2");
  const CommandResult trained = Trained(folder / "data", folder / "ours", "images_2");
  ASSERT_EQ(trained.code, 0) << trained.err;
  const std::string theirs = folder / "theirs", cloud = "/point_cloud/iteration_60";
  fs::create_directories(theirs + cloud);
  fs::copy_file(folder / "ours" + cloud + "/point_cloud.ply", theirs + cloud + "/point_cloud.ply");
  fs::copy_file(folder / "ours/cameras.json", theirs + "/cameras.json");
  std::ofstream(theirs + "/cfg_args")
      << "Namespace(data_device='cuda', depths='', eval=True, images='images_2', model_path='"
      << theirs << "', resolution=-1, sh_degree=3, source_path='" << (folder / "data")
      << "', train_test_exp=False, white_background=False)";
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"info", theirs},
           {"render", "-m", theirs},
           {"metrics", "-m", theirs},
           {"report", "-m", theirs},
           {"export", "-m", theirs, "--spz", folder / "a.spz"},
           {"play", theirs, "--headless", "-o", folder / "turn", "--frames", "2"}}) {
    const CommandResult result = Cosplat(command);
    EXPECT_EQ(result.code, 0) << command[0] << ": " << result.err;
  }
  const Json results = ReadJson(theirs + "/results.json");
  ASSERT_TRUE(results.contains("ours_60")) << results;
  EXPECT_EQ(results["ours_60"], ReadJson(folder / "ours/results.json")["ours_60"]);
  EXPECT_TRUE(fs::exists(theirs + "/report.html"));
  EXPECT_TRUE(fs::exists(folder / "a.spz"));
}

TEST(FolderOf3dgs, ItsOptionForImagesNamesTheirFolder) {
  const TemporaryFolder folder;
  WriteColmapScene(folder / "data", "undistorted");
  const CommandResult other = Trained(folder / "data", folder / "other", "images");
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.err.find("has no folder images"), std::string::npos) << other.err;
  fs::rename(folder / "data/undistorted", folder / "data/photos_2");
  EXPECT_EQ(Cosplat({"check", folder / "data", "-i", "photos", "-r", "2"}).code, 0);
  const CommandResult trained = Cosplat({"train-scene",
                                         "-s",
                                         folder / "data",
                                         "-m",
                                         folder / "run",
                                         "-i",
                                         "photos",
                                         "-r",
                                         "2",
                                         "--iterations",
                                         "3",
                                         "--eval",
                                         "--quiet"});
  ASSERT_EQ(trained.code, 0) << trained.err;
  const CommandResult rendered = Cosplat({"render", "-m", folder / "run"});
  EXPECT_EQ(rendered.code, 0) << rendered.err;
}

}  // namespace
}  // namespace cosplat::test

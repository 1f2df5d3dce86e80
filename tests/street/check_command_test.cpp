// `cosplat check` and --strict: exit codes and what they print.
#include <gtest/gtest.h>

#include <chrono>
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

// As training does: one is empty, one is cut off, beside 22 that are whole.
TEST(CheckCommand, NamesImagesThatAreLeftOut) {
  const Scenes scenes;
  const TemporaryFolder& folder = scenes.good.folder;
  std::filesystem::resize_file(folder / scenes.good.Frame(4), 0);
  std::filesystem::resize_file(folder / scenes.good.Frame(7), 100);
  const CommandResult checked = Cosplat({"check", folder.path(), "-o", folder / "page.html"});
  EXPECT_EQ(checked.code, 0) << checked.out << checked.err;
  EXPECT_NE(checked.out.find("1 of 24 images cannot be used and are left out (images/4.png"),
            std::string::npos)
      << checked.out;
  EXPECT_NE(checked.out.find("1 of 21 images looked at cannot be used and are left out (images/7"),
            std::string::npos)
      << checked.out;
  EXPECT_TRUE(std::filesystem::exists(folder / "page.html"));
  const TemporaryFolder out;
  const CommandResult trained =
      Cosplat({"train-scene", "-s", folder.path(), "-m", out / "run", "--iterations", "2"});
  EXPECT_EQ(trained.code, 0) << trained.err;
  EXPECT_NE(trained.out.find("2 frames skipped:"), std::string::npos) << trained.out;
}

TEST(CheckCommand, NamesMasksThatCannotBeRead) {
  const Scenes scenes;
  const TemporaryFolder& folder = scenes.good.folder;
  std::filesystem::create_directories(folder / "masks/images");
  WriteImage(folder / "masks/images/0.png", Image8(NerfScene::kWidth, NerfScene::kHeight, 1, 255));
  std::filesystem::resize_file(folder / "masks/images/0.png", 60);
  scenes.good.Load();
  const CommandResult checked = Cosplat({"check", folder.path()});
  EXPECT_EQ(checked.code, 0) << checked.out << checked.err;
  EXPECT_NE(checked.out.find("masks/images/0.png: is truncated after 60 bytes"), std::string::npos)
      << checked.out;
}

TEST(CheckCommand, RefusesAsTrainingWhatCannotBeRead) {
  const NerfScene scene{9};
  scene.Load();
  for (int i = 0; i < 4; ++i) std::filesystem::resize_file(scene.folder / scene.Frame(i), 100);
  const CommandResult checked = Cosplat({"check", scene.folder.path()});
  EXPECT_EQ(checked.code, 2) << checked.out;
  EXPECT_NE(checked.err.find("4 of 9 frames cannot be used"), std::string::npos) << checked.err;
  EXPECT_NE(checked.err.find("0.png"), std::string::npos) << checked.err;
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

// What is written never takes the place of what is read, or of a run's own files.
TEST(Outputs, DoNotReplaceInputs) {
  const TemporaryFolder folder;
  ASSERT_EQ(MakeSmallAvatar(folder), "");
  const std::string head = folder / "head", run = folder / "out";
  const auto refuses = [&](const std::vector<std::string>& arguments, const std::string& part) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 2) << result.out << result.err;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  };
  const std::string flame = head + "/model.npz", marks = head + "/landmarks.json";
  const auto refuses_track = [&](std::vector<std::string> more, const std::string& part) {
    more.insert(more.begin(),
                {"track",
                 head + "/image",
                 "--flame",
                 flame,
                 "--landmarks",
                 marks,
                 "--landmark-embedding",
                 head + "/landmark_embedding.npz"});
    refuses(more, part);
  };
  refuses_track({"-o", head}, "is the input");
  refuses_track({"-o", run + "/t", "--overlay", head + "/image"}, "is the input");
  refuses_track({"-o", run + "/t", "--focal", "9"}, "is in pixels");
  refuses({"render", "-m", run, "--random", "2", "-o", run + "/test/ours_4/gt"}, "its results");
  refuses({"export", "-m", run, "--ply", run + "/point_cloud/iteration_4/point_cloud.ply"},
          "is a file of the run");
  refuses({"export", "-m", run, "--ply", run + "/cameras.json"}, "is a file of the run");
  refuses({"export", "-m", run, "--glb", folder / "a.gltf"}, "would not know it");
  const std::vector<std::string> film{
      "render", "-m", run, "--random", "2", "-o", head + "/film.mp4", "--quiet"};
  for (int again = 0; again < 2; ++again) EXPECT_EQ(Cosplat(film).code, 0);
  std::ofstream(head + "/film.mp4") << "mine";
  std::filesystem::last_write_time(
      head + "/film.mp4",
      std::filesystem::last_write_time(run + "/run.json") - std::chrono::hours(1));
  refuses(film, "is a file of the data");
  EXPECT_EQ(Slurp(head + "/film.mp4"), "mine");
  std::ofstream(folder / "film.ts") << "mine";
  refuses({"stream", run, "--drive", folder / "none.csv", "--to", "file:" + (folder / "film.ts")},
          "none.csv");
  EXPECT_EQ(Slurp(folder / "film.ts"), "mine");
  EXPECT_EQ(Cosplat({"export", "-m", run, "--ply", "/dev/null"}).code, 0);
  std::filesystem::remove(run + "/run.json");
  refuses({"info", run}, "run.json");
}

}  // namespace
}  // namespace cosplat::test

// The `cosplat` command from end to end: what it writes, and that the parts fit together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "splat/base/npz.h"
#include "splat/io/ply.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

const Workshop& Made() { return Workshop::Get(); }

void ExpectQuietSuccess(const CommandResult& result) {
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
}

size_t CountFiles(const std::string& folder, const std::string& extension) {
  size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder))
    count += entry.path().extension() == extension;
  return count;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Cli, MakesTrainsAndSaysNothingWhenQuiet) {
  for (const CommandResult& result : Made().made) ExpectQuietSuccess(result);
}

// Whoever has only the log file sees that the run lives, and when it will end.
TEST(Cli, TrainingWritesALineEveryFewPercentWhereThereIsNoTerminal) {
  const TemporaryFolder folder;
  const CommandResult run =
      Cosplat({"train-scene", "-s", Made().photos, "-m", folder / "out", "--iterations", "40"});
  ASSERT_EQ(run.code, 0) << run.err;
  const std::regex line(
      "train [0-9]+/40  loss [0-9.]+  [0-9,]+ Gaussians  [0-9.]+ it/s  "
      "[0-9]+:[0-9]{2} left\n");
  const auto begin = std::sregex_iterator(run.err.begin(), run.err.end(), line);
  EXPECT_EQ(std::distance(begin, std::sregex_iterator()), 20) << run.err;
}

TEST(Cli, LeavesNoTemporaryFiles) {
  for (const auto& entry : fs::recursive_directory_iterator(Made().folder.path()))
    EXPECT_FALSE(Contains(entry.path().filename().string(), ".tmp")) << entry.path();
}

// One line that 3DGS's viewers evaluate.
TEST(Cli, WritesCfgArgs) {
  const std::string text = Slurp(Made().avatar + "/cfg_args");
  EXPECT_TRUE(std::regex_match(text, std::regex("Namespace\\(.*\\)"))) << text;
  for (const std::string part :
       {"sh_degree=2", "eval=True", "white_background=False", "resolution=1"})
    EXPECT_TRUE(Contains(text, part)) << text;
  EXPECT_TRUE(Contains(text, "source_path='" + fs::absolute(Made().head).string() + "'")) << text;
  EXPECT_TRUE(Contains(text, "model_path='" + fs::absolute(Made().avatar).string() + "'")) << text;
}

TEST(Cli, WritesTheConfigurationAndTheSeed) {
  const Json run = ReadJson(Made().avatar + "/run.json");
  EXPECT_EQ(run["kind"], "avatar");
  EXPECT_EQ(run["seed"], 0);
  EXPECT_EQ(run["iterations"], 60);
  EXPECT_EQ(run["flame"], Made().model);
  EXPECT_TRUE(run.contains("version"));
  const std::string config = Slurp(Made().avatar + "/config.ini");
  for (const std::string key : {"seed=0", "iterations=60", "gaussians=1500", "lambda_dssim=0.2"})
    EXPECT_TRUE(Contains(config, "train-avatar." + key + "\n")) << key;
  EXPECT_FALSE(Contains(config, "train-scene")) << "options of another command";
}

TEST(Cli, WritesResultsPerViewAndOverAll) {
  for (const auto& [folder, name, views] :
       {std::tuple{Made().avatar, "ours_60", 3u}, std::tuple{Made().scene, "ours_120", 6u}}) {
    const Json results = ReadJson(folder + "/results.json");
    const Json per_view = ReadJson(folder + "/per_view.json");
    for (const std::string figure : {"PSNR", "SSIM", "PSNR_mask"}) {
      ASSERT_TRUE(results[name].contains(figure)) << folder << figure;
      const Json& values = per_view[name][figure];
      ASSERT_EQ(values.size(), views) << folder << figure;
      double mean = 0;
      for (const auto& [view, value] : values.items()) mean += value.get<double>() / views;
      EXPECT_NEAR(results[name][figure].get<double>(), mean, 1e-9);
      EXPECT_TRUE(values.contains("00000.png"));
    }
    EXPECT_GT(results[name]["PSNR"].get<double>(), 10);
    EXPECT_LE(results[name]["SSIM"].get<double>(), 1);
  }
}

TEST(Cli, WritesStatistics) {
  for (const std::string& folder : {Made().avatar, Made().scene}) {
    const Json stats = ReadJson(folder + "/stats.json");
    for (const std::string key : {"iterations",
                                  "seconds",
                                  "cpu_seconds",
                                  "gaussians",
                                  "ms_per_step",
                                  "peak_mb",
                                  "skipped_frames"})
      EXPECT_TRUE(stats.contains(key) && stats[key].is_number()) << key;
    for (const std::string phase :
         {"project", "sort", "blend", "backward", "loss", "adam", "density"})
      EXPECT_GT(stats["phases_ms"].value(phase, 0.0), 0) << phase;
    EXPECT_GT(stats["seconds"].get<double>(), 0);
    EXPECT_GT(stats["peak_mb"].get<double>(), 1);
    EXPECT_EQ(stats["skipped_frames"], 0);
  }
  EXPECT_EQ(ReadJson(Made().avatar + "/stats.json")["iterations"], 60);
}

TEST(Cli, WritesSplatsCamerasAndTestImages) {
  const Json stats = ReadJson(Made().avatar + "/stats.json");
  const Gaussians last = ReadPly(Made().avatar + "/point_cloud/iteration_60/point_cloud.ply");
  EXPECT_EQ(last.size(), stats["gaussians"].get<size_t>());
  EXPECT_EQ(last.degree, 2);
  EXPECT_GT(ReadPly(Made().avatar + "/point_cloud/iteration_30/point_cloud.ply").size(), 0u);
  EXPECT_EQ(ReadJson(Made().avatar + "/cameras.json").size(), 12u);
  EXPECT_EQ(ReadJson(Made().scene + "/cameras.json").size(), 12u);
  EXPECT_TRUE(fs::exists(Made().scene + "/input.ply"));
  for (const std::string sub : {"renders", "gt", "masks"}) {
    EXPECT_EQ(CountFiles(Made().avatar + "/test/ours_60/" + sub, ".png"), 3u);
    EXPECT_EQ(CountFiles(Made().scene + "/test/ours_120/" + sub, ".png"), 6u);
  }
}

TEST(Cli, ConfigGivesTheSameBits) {
  const TemporaryFolder again;
  const std::string splats = "/point_cloud/iteration_60/point_cloud.ply";
  ExpectQuietSuccess(Cosplat({"train-avatar",
                              "--config",
                              Made().avatar + "/config.ini",
                              "-m",
                              again / "a",
                              "--threads",
                              "1"}));
  EXPECT_EQ(Slurp(again / ("a" + splats)), Slurp(Made().avatar + splats));
  EXPECT_EQ(Slurp(again / "a/avatar.glb"), Slurp(Made().avatar + "/avatar.glb"));
  EXPECT_EQ(Slurp(again / "a/results.json"), Slurp(Made().avatar + "/results.json"));
  // What is said on the command line comes first.
  ExpectQuietSuccess(Cosplat({"train-avatar",
                              "--config",
                              Made().avatar + "/config.ini",
                              "-m",
                              again / "b",
                              "--seed",
                              "1"}));
  EXPECT_NE(Slurp(again / ("b" + splats)), Slurp(Made().avatar + splats));

  const std::string scene_splats = "/point_cloud/iteration_120/point_cloud.ply";
  ExpectQuietSuccess(
      Cosplat({"train-scene", "--config", Made().scene + "/config.ini", "-m", again / "c"}));
  EXPECT_EQ(Slurp(again / ("c" + scene_splats)), Slurp(Made().scene + scene_splats));
}

TEST(Cli, RendersAnOrbitToAFolderAndToAVideo) {
  const TemporaryFolder out;
  for (const std::string& model : {Made().avatar, Made().scene}) {
    const std::string name = fs::path(model).filename().string();
    ExpectQuietSuccess(Cosplat({"render", "-m", model, "--orbit", "-o", out / name, "--quiet"}));
    EXPECT_EQ(CountFiles(out / name, ".png"), 120u);
    const Image8 first = ReadImage(out / (name + "/00000.png"));
    EXPECT_EQ(first.width,
              ReadImage(model + "/test/" + (name == "avatar" ? "ours_60" : "ours_120") +
                        "/renders/00000.png")
                  .width);
    ExpectQuietSuccess(
        Cosplat({"render", "-m", model, "--orbit", "-o", out / (name + ".mp4"), "--quiet"}));
    VideoReader video(out / (name + ".mp4"));
    EXPECT_EQ(video.frame_count(), 120);
  }
}

TEST(Cli, DrawsWhatOurOwnHeadCanDo) {
  const TemporaryFolder out;
  ASSERT_EQ(Cosplat({"make-head", "--sheets", out / "sheets"}).code, 0);
  EXPECT_NE(Cosplat({"make-head", "--sheets", out / "none", "--frames", "5"}).code, 0);
  for (const char* sheet : {"expressions", "shapes", "people"})
    EXPECT_EQ(ReadImage(out / ("sheets/" + std::string(sheet) + ".png")).width, 13 * 160) << sheet;
}

TEST(Cli, DrivesAnAvatarWithAnotherSequence) {
  const TemporaryFolder out;
  ASSERT_EQ(Cosplat({"make-head",
                     "-o",
                     out / "other",
                     "--frames",
                     "5",
                     "--test-frames",
                     "1",
                     "--size",
                     "32",
                     "--seed",
                     "9"})
                .code,
            0);
  fs::remove_all(out / "other/image");  // motion is all that is wanted
  fs::remove_all(out / "other/mask");
  ExpectQuietSuccess(Cosplat(
      {"render", "-m", Made().avatar, "--drive", out / "other", "-o", out / "played", "--quiet"}));
  EXPECT_EQ(CountFiles(out / "played", ".png"), 5u);
  const Image8 frame = ReadImage(out / "played/00002.png");
  EXPECT_EQ(frame.width, 64);  // as trained
  EXPECT_GT(*std::max_element(frame.data.begin(), frame.data.end()) -
                *std::min_element(frame.data.begin(), frame.data.end()),
            50);
}

double ImageError(const Image8& a, const Image8& b) {
  if (a.data.size() != b.data.size()) return 255;
  double squares = 0;
  for (size_t i = 0; i < a.data.size(); ++i)
    squares += std::pow(double(a.data[i]) - double(b.data[i]), 2);
  return std::sqrt(squares / double(a.data.size()));
}

TEST(Cli, APreviewHasTheSizeOfTheImageAndIsCloseToIt) {
  const TemporaryFolder out;
  for (const std::string& model : {Made().avatar, Made().scene}) {
    const std::string name = fs::path(model).filename().string();
    const std::string full = out / (name + "_full"), half = out / (name + "_half");
    ExpectQuietSuccess(Cosplat({"render", "-m", model, "-o", full, "--quiet"}));
    ExpectQuietSuccess(Cosplat({"render", "-m", model, "-o", half, "--preview", "--quiet"}));
    ASSERT_EQ(CountFiles(half, ".png"), CountFiles(full, ".png"));
    const double error = ImageError(ReadImage(half + "/00001.png"), ReadImage(full + "/00001.png"));
    EXPECT_GT(error, 0) << "it is no preview";
    EXPECT_LT(error, 10) << name;  // measured: 7.4 and 7.1 of 255, 64 and 32 pixels wide
  }
}

// Frames are drawn and encoded beside each other: all of them, in order, whatever the threads.
TEST(Cli, FramesDoNotDependOnThreads) {
  const TemporaryFolder out;
  for (const std::string threads : {"1", "3"})
    ExpectQuietSuccess(Cosplat({"--threads",
                                threads,
                                "render",
                                "-m",
                                Made().avatar,
                                "--drive",
                                Made().head,
                                "-o",
                                out / threads,
                                "--quiet"}));
  const size_t count = CountFiles(out / "1", ".png");
  ASSERT_EQ(count, CountFiles(out / "3", ".png"));
  ASSERT_GT(count, 3u);
  for (size_t i = 0; i < count; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "/%05zu.png", i);
    EXPECT_EQ(Slurp(out / "1" + name), Slurp(out / "3" + name)) << i;
  }
}

// Another's motion is limited to what training showed, and it is said.
TEST(Cli, DrivingFarBeyondTheTrainedRangeIsLimited) {
  const TemporaryFolder out;
  constexpr size_t count = 5;
  for (const float size : {50.0f, 5000.0f}) {
    const std::string name = out / std::to_string(int(size));
    Npz npz;
    npz.Add("expr", {1, count}, std::vector<float>(count, size));
    npz.Write(name + ".npz");
    const CommandResult result =
        Cosplat({"render", "-m", Made().avatar, "--drive", name + ".npz", "-o", name});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(Contains(result.out, "1 of 1 frames went beyond")) << result.out;
  }
  EXPECT_LT(ImageError(ReadImage(out / "50/00000.png"), ReadImage(out / "5000/00000.png")), 2);
}

TEST(Cli, RandomFacesDifferAndAreTheSameEveryTime) {
  const TemporaryFolder out;
  for (const std::string name : {"a", "b"})
    ExpectQuietSuccess(
        Cosplat({"render", "-m", Made().avatar, "--random", "3", "-o", out / name, "--quiet"}));
  ASSERT_EQ(CountFiles(out / "a", ".png"), 3u);
  EXPECT_EQ(Slurp(out / "a/00001.png"), Slurp(out / "b/00001.png"));
  EXPECT_GT(ImageError(ReadImage(out / "a/00000.png"), ReadImage(out / "a/00001.png")), 1);
}

int LargestDifference(const Image8& a, const Image8& b) {
  if (a.data.size() != b.data.size()) return 255;
  int largest = 0;
  for (size_t i = 0; i < a.data.size(); ++i)
    largest = std::max(largest, std::abs(int(a.data[i]) - int(b.data[i])));
  return largest;
}

// From the files alone: the images that training left at its end, and its figures.
TEST(Cli, RendersTheTestViewsAgainAndMeasuresThem) {
  for (const auto& [model, name] :
       {std::pair{Made().avatar, "ours_60"}, std::pair{Made().scene, "ours_120"}}) {
    const TemporaryFolder copy;
    fs::copy(model, copy / "run", fs::copy_options::recursive);
    fs::remove_all(copy / "run/test");
    fs::remove(copy / "run/results.json");
    ExpectQuietSuccess(Cosplat({"render", "-m", copy / "run", "--quiet"}));
    for (const auto& entry : fs::directory_iterator(model + "/test/" + name + "/renders")) {
      const std::string file =
          "/test/" + std::string(name) + "/renders/" + entry.path().filename().string();
      // A scene's splats went through 3DGS's SH and back.
      EXPECT_LE(LargestDifference(ReadImage(copy / ("run" + file)), ReadImage(model + file)), 1);
    }
    const CommandResult metrics = Cosplat({"metrics", "-m", copy / "run"});
    EXPECT_EQ(metrics.code, 0) << metrics.err;
    EXPECT_TRUE(Contains(metrics.out, "PSNR")) << metrics.out;
    const Json again = ReadJson(copy / "run/results.json"),
               first = ReadJson(model + "/results.json");
    ASSERT_EQ(again[name].size(), first[name].size());
    for (const auto& [figure, value] : first[name].items())
      EXPECT_NEAR(again[name][figure].get<double>(), value.get<double>(), 0.02) << figure;
  }
}

// Beside the figures on the tracks, which stay as they are.
TEST(Cli, MeasuresFittedTestFrames) {
  const TemporaryFolder copy;
  const std::string run = copy / "run";
  fs::copy(Made().avatar, run, fs::copy_options::recursive);
  const CommandResult fitted = Cosplat({"metrics", "-m", run, "--fit-track"});
  EXPECT_EQ(fitted.code, 0) << fitted.err;
  EXPECT_TRUE(Contains(fitted.out, "ours_60_fitted: PSNR")) << fitted.out;
  EXPECT_TRUE(Contains(fitted.out, "head")) << fitted.out;
  const Json results = ReadJson(run + "/results.json"),
             tracked = ReadJson(Made().avatar + "/results.json");
  for (const auto& [figure, value] : tracked["ours_60"].items())
    EXPECT_EQ(results["ours_60"][figure], value) << figure;
  EXPECT_GT(results["ours_60_fitted"]["PSNR"].get<double>(),
            tracked["ours_60"]["PSNR"].get<double>());
  const CommandResult scene = Cosplat({"metrics", "-m", Made().scene, "--fit-track"});
  EXPECT_EQ(scene.code, 2);
  EXPECT_TRUE(Contains(scene.err, "is for avatars")) << scene.err;
}

TEST(Cli, FindsExposuresAndFitsThoseOfTestImages) {
  const TemporaryFolder copy;
  const std::string run = copy / "run";
  ExpectQuietSuccess(Cosplat({"train-scene",
                              "-s",
                              Made().photos,
                              "-m",
                              run,
                              "--eval",
                              "--iterations",
                              "20",
                              "--exposure",
                              "--quiet"}));
  const Json exposures = ReadJson(run + "/exposure.json");
  ASSERT_FALSE(exposures.empty());
  EXPECT_EQ((*exposures.begin()).size(), 3u);
  const CommandResult fitted = Cosplat({"metrics", "-m", run, "--fit-exposure"});
  EXPECT_EQ(fitted.code, 0) << fitted.err;
  EXPECT_TRUE(Contains(fitted.out, "ours_20_exposed: PSNR")) << fitted.out;
  const Image8 whole = ReadImage(run + "/test/ours_20/gt/00000.png"),
               half = ReadImage(run + "/test/ours_20_exposed/gt/00000.png");
  EXPECT_EQ(half.width, whole.width - whole.width / 2);
  EXPECT_EQ(half.at(0, 5, 1), whole.at(whole.width / 2, 5, 1));
  EXPECT_TRUE(ReadJson(run + "/results.json")["ours_20_exposed"].contains("SSIM"));
}

TEST(Cli, KeepsToALimitOfMemory) {
  const TemporaryFolder copy;
  const auto train = [&](const std::string& run, const std::string& gb) {
    return Cosplat({"train-scene",
                    "-s",
                    Made().photos,
                    "-m",
                    copy / run,
                    "--iterations",
                    "40",
                    "--max-gaussians",
                    "3000",
                    "--memory",
                    gb});
  };
  const CommandResult free = train("free", "0"), kept = train("kept", "0.171");
  EXPECT_EQ(free.code, 0) << free.err;
  EXPECT_EQ(kept.code, 0) << kept.err;
  EXPECT_TRUE(Contains(free.out, "for 3,000 Gaussians")) << free.out;
  const auto stats = [&](const std::string& run) { return ReadJson(copy / run + "/stats.json"); };
  EXPECT_EQ(stats("free")["gaussians"].get<int>(), 3000);
  EXPECT_LT(stats("kept")["gaussians"].get<int>(), 2500);
  EXPECT_GT(stats("kept")["gaussians"].get<int>(), 500);
// The sanitizers take several times the memory.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(stats("kept")["peak_mb"].get<double>() * 1024 * 1024, 0.171e9);
#endif
  const CommandResult little = train("little", "0.1");
  EXPECT_EQ(little.code, 2);
  EXPECT_TRUE(Contains(little.err, "--memory: 0.10 GB is too little")) << little.err;
  EXPECT_FALSE(fs::exists(copy / "little/run.json"));
}

TEST(Cli, ReportsOnOnePage) {
  for (const std::string& model : {Made().avatar, Made().scene}) {
    const TemporaryFolder copy;
    fs::copy(model, copy / "run", fs::copy_options::recursive);
    ExpectQuietSuccess(Cosplat({"report", "-m", copy / "run", "--quiet"}));
    const std::string page = Slurp(copy / "run/report.html");
    EXPECT_TRUE(Contains(page, "data:image/jpeg;base64,"));
    EXPECT_TRUE(Contains(page, "PSNR"));
    EXPECT_TRUE(Contains(page, "</html>"));
    EXPECT_FALSE(Contains(page, "src='http")) << "loads from elsewhere";
    EXPECT_FALSE(fs::exists(copy / "run/report.tmp.jpg"));
  }
}

TEST(Cli, InfoKnowsWhatItIs) {
  const std::vector<std::pair<std::string, std::string>> kinds{
      {Made().head, "tracked video (imavatar): 9 training and 3 test frames of 64x64"},
      {Made().model, "FLAME model: 5"},
      {Made().avatar, "trained avatar: 60 iterations"},
      {Made().avatar + "/avatar.glb", "avatar (binding version 4)"},
      {Made().avatar + "/point_cloud/iteration_60/point_cloud.ply", "3DGS splats"},
      {Made().photos, "scene (blender): 6 training and 6 test views of 32x32"},
      {Made().scene, "trained scene: 120 iterations"}};
  for (const auto& [path, part] : kinds) {
    const CommandResult result = Cosplat({"info", path});
    EXPECT_EQ(result.code, 0) << path << result.err;
    EXPECT_TRUE(Contains(result.out, part)) << path << "\n" << result.out;
    EXPECT_EQ(result.err, "");
  }
}

// The initial guess is random points: what is learnt is the balls.
TEST(Cli, ASceneIsLearnt) {
  EXPECT_GT(ReadJson(Made().scene + "/results.json")["ours_120"]["PSNR"].get<double>(), 15);
}

}  // namespace
}  // namespace cosplat::test

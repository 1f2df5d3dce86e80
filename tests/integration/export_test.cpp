// `cosplat export` and what reads its files: `render --splats`, `metrics`, `info`.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/base/files.h"
#include "splat/io/ply.h"
#include "splat/io/splat_file.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

const Workshop& Made() { return Workshop::Get(); }

// A copy of the made scene that a test may write into.
class Export : public testing::Test {
 protected:
  Export() { fs::copy(Made().scene, scene_, fs::copy_options::recursive); }

  static std::string Run(const std::vector<std::string>& arguments) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return result.out;
  }
  // Exit code 2 and one line that has every part.
  static void Refuse(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& parts) {
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& part : parts)
      EXPECT_NE(result.err.find(part), std::string::npos) << result.err << " lacks " << part;
  }
  static bool Contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }

  TemporaryFolder folder_;
  std::string scene_ = folder_ / "scene";
  std::string ply_ = scene_ + "/point_cloud/iteration_120/point_cloud.ply";
};

TEST_F(Export, WritesAFileOfEachKind) {
  const std::string ply = folder_ / "a.ply", glb = folder_ / "a.glb";
  const std::string said = Run({"export", "-m", scene_, "--ply", ply, "--glb", glb});
  for (const std::string& file : {ply, glb}) EXPECT_TRUE(Contains(said, file)) << said;
  EXPECT_EQ(Slurp(ply), Slurp(ply_));
  EXPECT_TRUE(Contains(Run({"info", glb}), "KHR_gaussian_splatting"));
}

TEST_F(Export, SameBytesForAnyNumberOfThreads) {
  for (const std::string threads : {"1", "4"})
    EXPECT_EQ(
        Run({"export", "-m", scene_, "--sog", folder_ / threads, "--threads", threads, "--quiet"}),
        "");
  EXPECT_EQ(Slurp(folder_ / "1"), Slurp(folder_ / "4"));
}

TEST_F(Export, MeasuresWhatMetricsMeasures) {
  const std::string sog = folder_ / "small.sog";
  const std::string said =
      Run({"export", "-m", scene_, "--sog", sog, "--sog-palette", "20", "--measure"});
  const Json figures = ReadJson(scene_ + "/export.json");
  EXPECT_EQ(figures["ply_mb"].get<double>(), double(fs::file_size(ply_)) / 1e6);
  EXPECT_EQ(figures["sog_mb"].get<double>(), double(fs::file_size(sog)) / 1e6);
  EXPECT_EQ(figures["gaussians"], ReadPly(ply_).size());
  char psnr[32];
  std::snprintf(psnr, sizeof psnr, "PSNR %.2f dB", figures["sog_psnr"].get<double>());
  EXPECT_TRUE(Contains(said, psnr)) << said;

  const Json before = ReadJson(scene_ + "/results.json")["ours_120"];
  EXPECT_NEAR(figures["ply_psnr"].get<double>(), before["PSNR"].get<double>(), 0.01);
  Run({"render", "-m", scene_, "--splats", sog, "--quiet"});
  EXPECT_TRUE(Contains(Run({"metrics", "-m", scene_}), std::string("ours_120_small: ") + psnr));
  const Json after = ReadJson(scene_ + "/results.json");
  EXPECT_EQ(after["ours_120"], before);
  EXPECT_NEAR(
      after["ours_120_small"]["PSNR"].get<double>(), figures["sog_psnr"].get<double>(), 1e-9);
  EXPECT_NEAR(
      after["ours_120_small"]["SSIM"].get<double>(), figures["sog_ssim"].get<double>(), 1e-9);
}

TEST_F(Export, WritesFilesOfOthersAndMeasuresThem) {
  const std::string spz = folder_ / "a.spz", sog = folder_ / "a.sog", glb = folder_ / "a.glb";
  const std::string said =
      Run({"export", "-m", scene_, "--spz", spz, "--sog", sog, "--glb", glb, "--measure"});
  const Json figures = ReadJson(scene_ + "/export.json");
  for (const auto& [name, path] : {std::pair{"spz", spz}, {"sog", sog}, {"glb", glb}}) {
    EXPECT_TRUE(Contains(said, path)) << said;
    EXPECT_EQ(figures[std::string(name) + "_mb"].get<double>(), double(fs::file_size(path)) / 1e6);
    EXPECT_NEAR(
        figures[std::string(name) + "_psnr"].get<double>(), figures["ply_psnr"].get<double>(), 0.5);
    // Whatever the name.
    fs::copy(path, folder_ / "named");
    EXPECT_TRUE(Contains(Run({"info", folder_ / "named"}),
                         name == std::string("glb") ? "Gaussians" : "splats:"));
    Run({"render", "-m", scene_, "--splats", folder_ / "named", "--quiet"});
    Run({"export", "--splats", folder_ / "named", "--ply", folder_ / "back.ply"});
    EXPECT_EQ(ReadPly(folder_ / "back.ply").size(), ReadPly(ply_).size());
    fs::remove(folder_ / "named");
  }
  for (const std::string version : {"2", "4"}) {
    Run({"export", "-m", scene_, "--spz", spz, "--spz-version", version});
    EXPECT_EQ(ReadSplats(spz).size(), ReadPly(ply_).size());
  }
  Run({"export", "-m", scene_, "--sog", folder_ / "meta.json"});
  EXPECT_TRUE(Contains(Run({"info", folder_ / "meta.json"}), "SOG splats"));
  Refuse({"export", "-m", scene_, "--spz", spz, "--spz-version", "1"}, {"--spz-version"});
  Refuse({"export", "-m", Made().avatar, "--spz", spz, "--measure"}, {"--measure", "scenes"});
}

TEST_F(Export, TurnsFilesIntoEachOther) {
  const std::string spz = folder_ / "a.spz", ply = folder_ / "a.ply";
  Run({"export", "--splats", ply_, "--spz", spz});
  Run({"export", "--splats", spz, "--ply", ply});
  const Gaussians from_ply = ReadSplats(ply), from_spz = ReadSplats(spz);
  for (int a = 0; a < kAttributeCount; ++a) EXPECT_EQ(from_ply.values[a], from_spz.values[a]);
}

TEST_F(Export, LeavesBandFourOutWhereAsked) {
  Gaussians g = ReadPly(ply_);
  Gaussians four;
  four.degree = 4;
  four.basis = Basis::kSh;
  four.Resize(g.size());
  for (const Attribute a : {kPosition, kRotation, kScaleLog, kOpacityLogit, kColorDc})
    four.values[a] = g.values[a];
  WritePly(folder_ / "four.ply", four);
  const std::vector<std::string> command{
      "export", "--splats", folder_ / "four.ply", "--glb", folder_ / "a.glb"};
  Refuse(command, {"a.glb", "degree", "4", "--truncate-degree"});
  std::vector<std::string> truncating = command;
  truncating.push_back("--truncate-degree");
  Run(truncating);
  EXPECT_TRUE(Contains(Run({"info", folder_ / "a.glb"}), "degree 3"));
}

TEST_F(Export, SaysThatAnAvatarIsAtRest) {
  const std::string said = Run({"export", "-m", Made().avatar, "--ply", folder_ / "a.ply"});
  EXPECT_TRUE(Contains(said, "at rest")) << said;
  // Seen from the side that its .glb is seen from, although FLAME's axes are not those of scenes.
  const Gaussians ply = ReadSplats(folder_ / "a.ply");
  const Gaussians glb = ReadSplats(Made().avatar + "/avatar.glb");
  EXPECT_EQ(ply.values[kPosition], glb.values[kPosition]);
  ASSERT_EQ(ply.values[kColorRest].size(), glb.values[kColorRest].size());
  for (size_t i = 0; i < ply.values[kColorRest].size(); ++i)
    EXPECT_NEAR(ply.values[kColorRest][i], glb.values[kColorRest][i], 1e-6f);
  const Gaussians of_run = ReadSplats(Made().avatar + "/point_cloud/iteration_60/point_cloud.ply");
  EXPECT_EQ(ply.at(kPosition, 0)[1], -of_run.at(kPosition, 0)[1]);
  EXPECT_EQ(ply.at(kPosition, 0)[2], -of_run.at(kPosition, 0)[2]);
  Refuse({"export", "-m", Made().avatar, "--glb", folder_ / "a.glb"}, {"--glb", "avatar.glb"});
}

TEST_F(Export, BadInput) {
  const std::string out = folder_ / "out.sog";
  Refuse({"export", "-m", scene_}, {"--ply", "--glb", "--sog"});
  Refuse({"export", "--sog", out}, {"-m", "--splats"});
  Refuse({"export", "-m", scene_, "--ply", out}, {"--ply", "ends in .sog"});
  Refuse({"export", "-m", scene_, "--ply", out, "--measure"}, {"--measure", "--sog"});
  Refuse({"export", "--splats", ply_, "--sog", out, "--measure"}, {"--measure"});
  Refuse({"export", "-m", scene_, "--sog", out, "--sog-palette", "0"}, {"--sog-palette"});
  Refuse({"export", "-m", scene_, "-s", folder_ / "gone", "--sog", out}, {"gone"});
  Refuse({"export", "-m", folder_ / "no", "--sog", out}, {"no/run.json"});
  Refuse({"render", "-m", Made().avatar, "--splats", ply_}, {"--splats", "scenes"});
  Refuse({"export", "-m", Made().avatar, "--splats", ply_, "--sog", out}, {"--splats", "scenes"});
  EXPECT_FALSE(fs::exists(out));
  Json run = ReadJson(scene_ + "/run.json");
  run["split"]["eval"] = false;
  WriteFileAtomically(scene_ + "/run.json", run.dump());
  Refuse({"export", "-m", scene_, "--sog", out, "--measure"}, {"--measure", "--eval"});

  Run({"export", "--splats", ply_, "--sog", out});
  const std::string whole = Slurp(out);
  WriteFileAtomically(out, whole.substr(0, whole.size() / 2));
  Refuse({"render", "-m", scene_, "--splats", out}, {"out.sog"});
  Refuse({"info", out}, {"out.sog"});
  Refuse({"export", "--splats", out, "--ply", folder_ / "a.ply"}, {"out.sog"});
}

}  // namespace
}  // namespace cosplat::test

// `cosplat metrics --lpips` as a user runs it, on a run that is made of two pairs of images.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/eval/lpips.h"
#include "tests/integration/command.h"
#include "tests/support/tiny_onnx.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

void Spill(const std::string& path, const std::string& bytes) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Image8 Stripes(int period) {
  Image8 image(16, 12, 3);
  for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = uint8_t(i * 37 % period);
  return image;
}

class MetricsCommand : public testing::Test {
 protected:
  MetricsCommand() {
    for (const std::string net : {"tiny", "other"}) WriteTinyLpips(folder_ / net, net);
    Json run{{"iterations", 60}, {"kind", "scene"}, {"source", "photos"}};
    Spill(run_ + "/run.json", run.dump());
    Spill(run_ + "/point_cloud/iteration_60/point_cloud.ply", "");
    Json stats{{"gaussians", 1},
               {"iterations", 60},
               {"seconds", 1},
               {"ms_per_step", 1},
               {"peak_mb", 1},
               {"phases_ms", {{"blend", 1}}}};
    Spill(run_ + "/stats.json", stats.dump());
    for (const char* sub : {"renders", "gt"}) fs::create_directories(test_ + sub);
    for (int i = 0; i < 2; ++i) {
      const std::string name = "/0000" + std::to_string(i) + ".png";
      WriteImage(test_ + "renders" + name, Stripes(150 + 40 * i));
      WriteImage(test_ + "gt" + name, Stripes(220));
    }
  }

  CommandResult Measure(const std::string& net = "") const {
    std::vector<std::string> arguments{"metrics", "-m", run_};
    if (!net.empty()) arguments.insert(arguments.end(), {"--lpips", folder_ / net});
    const CommandResult result = Cosplat(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return result;
  }

  void ExpectRefused(const std::string& net, const std::vector<std::string>& parts) const {
    const CommandResult result = Cosplat({"metrics", "-m", run_, "--lpips", folder_ / net});
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& part : parts)
      EXPECT_TRUE(Contains(result.err, part)) << result.err << " lacks " << part;
    EXPECT_FALSE(fs::exists(run_ + "/results.json"));
  }

  Json Results() const { return ReadJson(run_ + "/results.json")["ours_60"]; }
  Json PerView() const { return ReadJson(run_ + "/per_view.json")["ours_60"]; }

  const TemporaryFolder folder_;
  const std::string run_ = folder_ / "run", test_ = run_ + "/test/ours_60/";
};

TEST_F(MetricsCommand, WithoutANetThereIsNoLpips) {
  EXPECT_FALSE(Contains(Measure().out, "LPIPS"));
  EXPECT_EQ(Results().size(), 2u) << Results();
  EXPECT_EQ(PerView().size(), 2u) << PerView();
}

TEST_F(MetricsCommand, NamesTheNetEverywhere) {
  const std::string line = Measure("tiny").out;
  Lpips lpips(folder_ / "tiny");
  double mean = 0;
  for (const std::string name : {"00000.png", "00001.png"}) {
    const double value =
        lpips.Distance(ReadImage(test_ + "renders/" + name), ReadImage(test_ + "gt/" + name));
    EXPECT_GT(value, 0);
    EXPECT_EQ(PerView()["LPIPS_tiny"][name].get<double>(), value);
    EXPECT_EQ(PerView()["LPIPS"][name].get<double>(), value);
    mean += value / 2;
  }
  EXPECT_DOUBLE_EQ(Results()["LPIPS_tiny"].get<double>(), mean);
  EXPECT_EQ(Results()["LPIPS"], Results()["LPIPS_tiny"]);
  char value[32];
  std::snprintf(value, sizeof value, "%.4f", mean);
  EXPECT_TRUE(Contains(line, std::string("  LPIPS (tiny) ") + value + "  (2 views)\n")) << line;
  EXPECT_EQ(Cosplat({"report", "-m", run_, "--quiet"}).code, 0);
  const std::string page = Slurp(run_ + "/report.html");
  EXPECT_TRUE(Contains(page, std::string("<th>LPIPS (tiny)</th><td>") + value + "</td>"));
}

TEST_F(MetricsCommand, FiguresOfOtherNetsStay) {
  Measure("tiny");
  const Json tiny = Results();
  EXPECT_TRUE(Contains(Measure().out, "LPIPS (tiny)"));
  EXPECT_EQ(Results(), tiny);
  const std::string npz = folder_ / "other/other_lin.npz";
  Npz lins = Npz::Read(npz);
  lins.Add("lin0", {2}, std::vector<float>{7, 7});
  lins.Write(npz);
  EXPECT_TRUE(Contains(Measure("other").out, "LPIPS (tiny)"));
  EXPECT_EQ(Results()["LPIPS_tiny"], tiny["LPIPS_tiny"]);
  EXPECT_NE(Results()["LPIPS_other"], tiny["LPIPS_tiny"]);
  EXPECT_EQ(Results()["LPIPS"], Results()["LPIPS_other"]) << "the last one measured";
}

TEST_F(MetricsCommand, FiguresOfOtherImagesGo) {
  Measure("tiny");
  Image8 changed = ReadImage(test_ + "renders/00001.png");
  changed.data[5] ^= 1;
  WriteImage(test_ + "renders/00001.png", changed);
  const std::string out = Measure().out;
  EXPECT_TRUE(Contains(out, "dropped: ours_60: LPIPS, LPIPS_tiny of images that have changed"))
      << out;
  EXPECT_EQ(Results().size(), 2u) << Results();
  Spill(run_ + "/per_view.json", "{\"ours_60\": ");
  const std::string damaged = Measure().out;
  EXPECT_TRUE(Contains(damaged, "dropped: ") && Contains(damaged, "per_view.json")) << damaged;
  EXPECT_EQ(PerView().size(), 2u);
}

TEST_F(MetricsCommand, BadNetsAreOneLineAndChangeNothing) {
  ExpectRefused("absent", {folder_ / "absent"});
  fs::remove(folder_ / "tiny/tiny_taps.txt");
  ExpectRefused("tiny", {folder_ / "tiny/tiny_taps.txt"});
  Spill(folder_ / "other/other_backbone.onnx", "no network");
  ExpectRefused("other", {folder_ / "other/other_backbone.onnx"});
  WriteTinyLpips(folder_ / "tiny", "tiny");
  Image8 low(16, 3, 3);
  for (size_t i = 0; i < low.data.size(); ++i) low.data[i] = uint8_t(i * 37 % 220);
  for (const char* sub : {"renders", "gt"}) WriteImage(test_ + sub + "/00000.png", low);
  ExpectRefused("tiny", {folder_ / "tiny/tiny_backbone.onnx", "at least 4x4", "16x3"});
}

}  // namespace
}  // namespace cosplat::test

// `cosplat-study bench --quick` from end to end: every figure and every chart is there. Nothing is
// said about how large the figures are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "tests/integration/command.h"
#include "tests/splat/ply_packer.h"
#include "tests/study/well_formed.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

constexpr size_t kSplats = 300;

struct BenchFolder {
  TemporaryFolder folder;
  std::string out = folder / "deep/bench", scene = folder / "balls";
  std::string splats = folder / "cloud.ply";
  CommandResult result;
  Json json;

  BenchFolder() {
    WriteBallScene(scene, 5);
    WriteFileAtomically(splats, PackedFile(RandomSplats(kSplats), {}));
    result = Cosplat(
        {"bench", "-o", out, "--quick", "-s", scene, "-r", "2", "--splats", splats, "--quiet"});
    if (result.code == 0) json = ReadJson(out + "/bench.json");
  }
  static const BenchFolder& Get() {
    static const BenchFolder made;
    return made;
  }
};

const BenchFolder& Made() { return BenchFolder::Get(); }

// Every number below `json` is finite and positive; counts them.
size_t CountPositive(const Json& json, const std::string& path) {
  size_t count = json.is_number() ? 1 : 0;
  EXPECT_FALSE(json.is_null()) << path << " is not a finite number";
  if (json.is_number()) {
    EXPECT_TRUE(std::isfinite(json.get<double>()) && json.get<double>() > 0) << path << json;
  }
  for (const auto& [key, value] : json.items())
    if (&value != &json) count += CountPositive(value, path + "/" + key);
  return count;
}

TEST(BenchCommand, SaysNothingWhenQuiet) {
  EXPECT_EQ(Made().result.code, 0) << Made().result.err;
  EXPECT_EQ(Made().result.out, "");
  EXPECT_EQ(Made().result.err, "");
}

TEST(BenchCommand, WritesEveryFigure) {
  const Json& json = Made().json;
  for (const std::string key : {"cpu", "simd"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_NE(json[key], "");
  }
  for (const std::string key : {"threads",
                                "blend_forward_ns_per_pixel_splat",
                                "blend_backward_ns_per_pixel_splat",
                                "fma_peak_gflops",
                                "stream_gbs",
                                "avatar_fps"}) {
    ASSERT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(CountPositive(json[key], key), 1u);
  }
}

TEST(BenchCommand, WritesASeriesAndAChartOfEach) {
  const Json& json = Made().json;
  size_t charts = 0;
  for (const auto& [key, series] : json.items()) {
    if (!series.is_object()) continue;
    ++charts;
    SCOPED_TRACE(key);
    EXPECT_TRUE(series.contains("title"));
    EXPECT_NE(series.value("statistic", ""), "");
    for (const Json& one : series["series"]) EXPECT_GE(CountPositive(one["points"], key), 1u);
    const std::string svg = Slurp(Made().out + "/" + key + ".svg");
    EXPECT_EQ(ProblemOfXml(svg), "");
    EXPECT_EQ(svg.rfind("<svg xmlns=\"http://www.w3.org/2000/svg\"", 0), 0u);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
  for (const std::string key : {"blend",
                                "fma",
                                "stream",
                                "pairs",
                                "pair_times",
                                "phases",
                                "step_gaussians",
                                "step_pixels",
                                "step_trained",
                                "step_threads",
                                "playback",
                                "accuracy",
                                "accuracy_time",
                                "memory",
                                "shortcuts",
                                "shortcuts_given",
                                "orbit"})
    EXPECT_TRUE(json.contains(key)) << key;
  // Those, the page, bench.json and orbit.png; nothing temporary.
  const auto files = fs::directory_iterator(Made().out);
  EXPECT_EQ(size_t(std::distance(begin(files), end(files))), charts + 3);
}

TEST(BenchCommand, MeasuresTheSceneThatItIsGiven) {
  for (const std::string key : {"pairs", "phases", "accuracy", "shortcuts_given"})
    EXPECT_NE(Made().json[key].dump().find("balls"), std::string::npos) << key;
}

TEST(BenchCommand, DrawsTheSplatsThatItIsGivenFromAllAround) {
  const Json& orbit = Made().json["orbit"];
  EXPECT_NE(orbit["title"].dump().find("cloud.ply"), std::string::npos);
  EXPECT_EQ(orbit["series"][0]["points"].size(), 36u);
  EXPECT_EQ(orbit["splats"], kSplats);
  EXPECT_EQ(orbit["threads"], Made().json["threads"]);
  EXPECT_EQ(CountPositive(orbit["frames_per_second"], "orbit"), 1u);
  EXPECT_EQ(CountPositive(orbit["phase_ms"], "orbit"), 3u);
  const Image8 image = ReadImage(Made().out + "/orbit.png");
  EXPECT_EQ(image.width, orbit["width"]);
  EXPECT_EQ(image.height, orbit["height"]);
  EXPECT_GT(*std::max_element(image.data.begin(), image.data.end()), 0);
}

TEST(BenchCommand, SplitsWhatTrainingHolds) {
  const Json& json = Made().json["memory"];
  EXPECT_EQ(CountPositive(json["bytes_per_gaussian"], "memory"), 3u);  // random, head, balls
  EXPECT_EQ(CountPositive(json["bytes_of_pixels"], "memory"), 3u);
  EXPECT_EQ(CountPositive(json["resident_bytes_per_gaussian"], "memory"), 1u);
}

// The default is among the points of everything that is varied.
TEST(BenchCommand, WeighsEveryShortcut) {
  for (const std::string key : {"shortcuts", "shortcuts_given"}) {
    const Json& json = Made().json[key];
    EXPECT_EQ(CountPositive(json["iterations"], key) + CountPositive(json["seeds"], key), 2u);
    EXPECT_EQ(CountPositive(json["psnr_deviation"], key), 5u);
    std::vector<size_t> counts;
    for (const Json& one : json["series"]) counts.push_back(one["points"].size());
    EXPECT_EQ(counts, (std::vector<size_t>{4, 2}));
    const Json first = json["series"][0]["points"][0];
    for (const Json& one : json["series"]) {
      const auto same = [&](const Json& point) {
        return point["x"] == first["x"] && point["y"] == first["y"];
      };
      EXPECT_EQ(std::count_if(one["points"].begin(), one["points"].end(), same), 1) << key;
    }
  }
}

TEST(BenchCommand, ShowsEveryChartOnOnePage) {
  const std::string page = Slurp(Made().out + "/index.html");
  size_t shown = 0;
  for (size_t at = page.find("<figure>"); at != std::string::npos;
       at = page.find("<figure>", at + 1))
    ++shown;
  size_t charts = 0;
  for (const auto& [key, series] : Made().json.items()) charts += series.is_object();
  EXPECT_EQ(shown, charts);
  EXPECT_EQ(page.find("src="), std::string::npos) << "loads something";
}

void ExpectRefused(const std::vector<std::string>& arguments, const std::string& part) {
  const CommandResult result = Cosplat(arguments);
  EXPECT_EQ(result.code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
}

TEST(BenchCommand, RefusesBadInputBeforeItMeasures) {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "a file";
  ExpectRefused({"bench", "--quick"}, "--out");
  ExpectRefused({"bench", "--quick", "-o", folder / "file/bench"}, "file/bench");
  ExpectRefused({"bench", "--quick", "-o", folder / "bench", "-s", folder / "none"}, "none");
  ExpectRefused({"bench", "--quick", "-o", folder / "bench", "-r", "0"}, "--resolution");
  ExpectRefused({"bench", "--quick", "-o", folder / "bench", "--splats", folder / "no.ply"},
                "no.ply");
  WriteFileAtomically(folder / "cut.sog", "PK\3\4");
  ExpectRefused({"bench", "--quick", "-o", folder / "bench", "--splats", folder / "cut.sog"},
                "cut.sog: cannot be read as SOG");
  std::vector<Unpacked> splats = RandomSplats(3);
  for (Unpacked& s : splats) s.opacity = 0;
  WriteFileAtomically(folder / "clear.ply", PackedFile(splats, {}));
  ExpectRefused({"bench", "--quick", "-o", folder / "bench", "--splats", folder / "clear.ply"},
                "no splat is visible");
  WriteFileAtomically(folder / "one.ply", PackedFile(RandomSplats(1), {}));
  ExpectRefused({"bench", "--quick", "-o", folder / "bench", "--splats", folder / "one.ply"},
                "zero height");
  EXPECT_FALSE(fs::exists(folder / "bench"));
}

}  // namespace
}  // namespace cosplat::test

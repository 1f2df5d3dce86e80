// What `cosplat study` makes of a list, of lines and of figures, without training anything.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "apps/cosplat/study_charts.h"
#include "apps/cosplat/study_list.h"
#include "apps/cosplat/study_page.h"
#include "splat/base/json.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

using Strings = std::vector<std::string>;

TEST(StudyStatistics, MeanAndStandardError) {
  const Estimate four = EstimateOf({1, 2, 3, 4});
  EXPECT_DOUBLE_EQ(four.mean, 2.5);
  EXPECT_DOUBLE_EQ(four.error, std::sqrt(5.0 / 3 / 4));  // squares 2.25 0.25 0.25 2.25; n - 1 = 3
  EXPECT_EQ(four.count, 4u);
  EXPECT_EQ(EstimateOf({7}).mean, 7);
  EXPECT_EQ(EstimateOf({7}).error, 0);
  EXPECT_EQ(ToString(four, 2), "2.50 ± 0.65");
  EXPECT_EQ(ToString(EstimateOf({12345}), 0), "12,345");
  EXPECT_EQ(ToString(std::nullopt, 2), "-");
  EXPECT_EQ(SignedText(EstimateOf({-0.5}), 1), "−0.5");
  EXPECT_EQ(SignedText(EstimateOf({0.5, 1.5}), 1), "+1.0 ± 0.5");
}

// A point that another equals stays; one that another beats in one figure alone does not.
TEST(StudyStatistics, ParetoFront) {
  const std::vector<CostAndQuality> points{{1, 20}, {2, 30}, {2, 29}, {3, 30}, {4, 31}, {4, 31}};
  EXPECT_EQ(ParetoFront(points), (std::vector<bool>{true, true, false, false, true, true}));
  EXPECT_TRUE(ParetoFront({}).empty());
}

StudyLine LineOf(const std::string& name, int seed, double psnr, double gaussians = 1000) {
  StudyLine line;
  line.data = "fox";
  line.name = line.label = name;
  line.groups = {"bases"};
  line.seed = seed;
  line.command = "cosplat train-scene -s fox -m MODEL";
  line.version = "1";
  line.cpu = "a processor";
  line.checkpoints = {{{"iterations", 10}, {"PSNR", psnr - 1}},
                      {{"iterations", 20},
                       {"PSNR", psnr},
                       {"SSIM", psnr / 100},
                       {"LPIPS_squeeze", 1 / psnr},
                       {"gaussians", gaussians},
                       {"fps", 1e5 / gaussians}}};
  return line;
}

// Differences of a seed have a scatter of their own: 0.5 and 0.7 here, of runs that differ by 2.
TEST(StudyStatistics, DifferencesArePairedBySeed) {
  const std::vector<StudyPoint> points = PointsOf({LineOf("a", 0, 30.5),
                                                   LineOf("a", 1, 32.7),
                                                   LineOf("b", 1, 32.0),
                                                   LineOf("b", 0, 30.0),
                                                   LineOf("b", 2, 99.0)});
  ASSERT_EQ(points.size(), 2u);
  const auto difference = PairedDifference(points[0], points[1], "PSNR");
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->count, 2u);
  EXPECT_NEAR(difference->mean, 0.6, 1e-9);
  EXPECT_NEAR(difference->error, 0.1, 1e-9);
  EXPECT_FALSE(PairedDifference(points[0], points[1], "unknown"));
  EXPECT_NEAR(points[0].At("PSNR", 10)->mean, 30.6, 1e-9);
  EXPECT_EQ(points[0].Iterations(), (std::set<int>{10, 20}));
}

class StudyListTest : public testing::Test {
 protected:
  std::string Write(const std::string& text) const {
    const std::string path = folder_ / "list.json";
    std::ofstream(path) << text;
    return path;
  }
  // `changed` in place of a part of a list that is good.
  void ExpectRefused(const std::string& part,
                     const std::string& changed,
                     const Strings& named) const {
    std::string text = kGood;
    const size_t at = text.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    text.replace(at, part.size(), changed);
    ExpectError([&] { ReadStudyList(Write(text)); }, named);
  }

  static constexpr const char* kGood = R"({
    "defaults": {"arguments": ["--eval"], "seeds": [0, 5], "checkpoints": [10]},
    "data": [
      {"name": "fox", "kind": "scene", "source": "a fox", "counts": [200, 100]},
      {"name": "head", "kind": "avatar", "make_head": ["--size", "64"], "seeds": [3],
       "checkpoints": []}],
    "runs": [
      {"name": "dcsh", "label": "DCSH", "groups": ["bases", "pruning"], "minus": ["sh"]},
      {"name": "sh", "arguments": ["--basis", "sh"]},
      {"name": "speedy", "arguments": ["--prune-to", "{count}"], "data": ["fox"]},
      {"name": "lp", "arguments": ["--prune_lambda", "{value}"], "values": [5e-4, 2],
       "data": ["head"]}]})";
  const TemporaryFolder folder_;
};

TEST_F(StudyListTest, CrossesSettingsDataAndSeeds) {
  Strings ids;
  for (const StudyRun& run : ReadStudyList(Write(kGood))) ids.push_back(run.Id());
  EXPECT_EQ(ids,
            (Strings{"fox/dcsh/0",
                     "fox/sh/0",
                     "fox/speedy-200/0",
                     "fox/speedy-100/0",
                     "head/dcsh/3",
                     "head/sh/3",
                     "head/lp-0.0005/3",
                     "head/lp-2/3",
                     "fox/dcsh/5",
                     "fox/sh/5",
                     "fox/speedy-200/5",
                     "fox/speedy-100/5"}));
}

TEST_F(StudyListTest, CommandsHoldOnAnyMachine) {
  const std::vector<StudyRun> runs = ReadStudyList(Write(kGood));
  EXPECT_EQ(runs[3].Command(),
            "cosplat train-scene -s 'a fox' -m MODEL --eval --prune-to 100 --seed 0 "
            "--test_iterations 10 --save_iterations 10");
  EXPECT_EQ(runs[6].Command(),
            "cosplat make-head -o head --size 64 && cosplat train-avatar -s head --flame "
            "head/model.npz -m MODEL --eval --prune_lambda 0.0005 --seed 3");
  EXPECT_EQ(runs[0].TrainArguments("data/", "out/", "m")[2], "data/a fox");
  EXPECT_EQ(runs[6].TrainArguments("data/", "out/", "m")[2], "out/head");
  EXPECT_EQ(runs[0].label, "DCSH");
  EXPECT_EQ(runs[0].groups, (Strings{"bases", "pruning"}));
  EXPECT_EQ(runs[1].label, "sh");
}

TEST_F(StudyListTest, NamesWhatIsWrong) {
  const std::string file = folder_ / "list.json";
  ExpectRefused("\"label\"", "\"lable\"", {file, "runs[0].lable"});
  ExpectRefused("\"kind\": \"scene\"", "\"kind\": \"film\"", {file, "data[0].kind", "film"});
  ExpectRefused("\"source\": \"a fox\", ", "", {file, "data[0].source", "missing"});
  ExpectRefused(", \"counts\": [200, 100]", "", {file, "runs[2].arguments", "{count}", "fox"});
  ExpectRefused("\"values\": [5e-4, 2],", "", {file, "runs[3].values"});
  ExpectRefused("\"values\": [5e-4, 2]", "\"values\": [\"x\"]", {file, "runs[3].values[0]", "x"});
  ExpectRefused("{value}", "0.1", {file, "runs[3].values", "{value}"});
  ExpectRefused("\"data\": [\"fox\"]", "\"data\": [\"dog\"]", {file, "runs[2].data", "dog"});
  ExpectRefused("\"minus\": [\"sh\"]", "\"minus\": [\"sch\"]", {file, "dcsh", "sch"});
  ExpectRefused("\"name\": \"sh\"", "\"name\": \"dcsh\"", {file, "two", "fox/dcsh/0"});
  ExpectRefused("\"name\": \"sh\"", "\"name\": \"../sh\"", {file, "runs[1].name", "../sh"});
  ExpectRefused("[0, 5]", "[0, -5]", {file, "defaults.seeds[1]", "-5"});
  ExpectRefused("[0, 5]", "[0, 5", {file, "line 2"});
  ExpectRefused("[\"--eval\"]", "\"--eval\"", {file, "defaults.arguments", "--eval"});
}

Strings IdsIn(const std::string& folder) {
  Strings ids;
  for (const StudyLine& line : ReadStudyLines(folder).lines) ids.push_back(line.Id());
  return ids;
}

TEST(StudyLines, LeavesOutALineThatWasCutAndGoesOn) {
  const TemporaryFolder folder;
  const std::string file = folder / "runs.jsonl";
  {
    StudyLog log(folder.path());
    log.Append(LineOf("a", 0, 30));
    log.Append(LineOf("b", 0, 31));
  }
  const Strings both{"fox/a/0", "fox/b/0"};
  EXPECT_EQ(IdsIn(folder.path()), both);
  EXPECT_EQ(ReadStudyLines(folder.path()).lines[1].checkpoints, LineOf("b", 0, 31).checkpoints);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 20);
  EXPECT_EQ(IdsIn(folder.path()), Strings{"fox/a/0"});
  StudyLog(folder.path()).Append(LineOf("b", 0, 31));
  EXPECT_EQ(IdsIn(folder.path()), both);
}

TEST(StudyLines, OfSeveralFilesAddUpAndTheLaterCounts) {
  const TemporaryFolder folder;
  StudyLog(folder.path()).Append(LineOf("a", 0, 30));
  std::filesystem::rename(folder / "runs.jsonl", folder / "monday.jsonl");
  StudyLog log(folder.path());
  log.Append(LineOf("b", 0, 31));
  log.Append(LineOf("a", 0, 32));
  const StudyLines all = ReadStudyLines(folder.path());
  ASSERT_EQ(all.lines.size(), 2u);
  EXPECT_EQ(all.lines[0].checkpoints.back().at("PSNR"), 32);
  EXPECT_EQ(all.replaced, Strings{"fox/a/0"});
  ExpectError([&] { StudyLog second(folder.path()); }, {"runs.jsonl", "another study"});
}

TEST(StudyLines, NamesTheLineThatIsNoGood) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& bad, const Strings& named) {
    std::filesystem::remove(folder / "runs.jsonl");
    StudyLog(folder.path()).Append(LineOf("a", 0, 30));
    std::ofstream(folder / "runs.jsonl", std::ios::app) << bad << "\n";
    ExpectError([&] { ReadStudyLines(folder.path()); }, named);
  };
  expect("{\"data\":", {"runs.jsonl, line 2", "JSON"});
  expect("{\"data\": 7}", {"runs.jsonl, line 2", "data", "7"});
  std::ostringstream text;
  StudyLine line = LineOf("b", 0, 30);
  line.checkpoints.clear();
  std::filesystem::remove(folder / "runs.jsonl");
  StudyLog(folder.path()).Append(line);
  ExpectError([&] { ReadStudyLines(folder.path()); }, {"line 1", "checkpoints"});
}

TEST(StudyCharts, HoldMeansErrorsCurvesAndTheFront) {
  std::vector<StudyLine> lines;
  for (int seed = 0; seed < 2; ++seed) {
    lines.push_back(LineOf("many", seed, 30 + seed, 9000));
    lines.push_back(LineOf("few", seed, 28 + seed, 1000));
    lines.push_back(LineOf("worse", seed, 27 + seed, 4000));
  }
  for (StudyLine& line : lines)
    if (line.name != "worse") line.label = "good";
  const std::vector<StudyPoint> points = PointsOf(lines);
  const std::vector<StudyFigure> qualities = QualitiesIn(points);
  ASSERT_EQ(qualities.size(), 3u);
  EXPECT_EQ(qualities[2].name, "LPIPS (squeeze)");
  const std::vector<StudyChart> charts = StudyCharts(points, "bases", qualities[0]);
  ASSERT_EQ(charts.size(), 2u);  // against Gaussians and against frames per second
  EXPECT_EQ(charts[0].key, "fox-bases-psnr-gaussians");
  const Chart& chart = charts[0].chart;
  EXPECT_TRUE(chart.x.log);
  ASSERT_EQ(chart.series.size(), 2u);
  EXPECT_EQ(chart.series[0].name, "good");
  ASSERT_EQ(chart.series[0].marks.size(), 2u);
  EXPECT_EQ(chart.series[0].marks[0].x, 1000);  // the curve begins with the fewest
  EXPECT_EQ(chart.series[0].marks[0].y, 28.5);
  EXPECT_DOUBLE_EQ(chart.series[0].marks[0].y_error, 0.5);
  EXPECT_EQ(chart.series[0].marks[0].label, "good");
  EXPECT_TRUE(chart.series[0].marks[0].ringed && chart.series[0].marks[1].ringed);
  EXPECT_FALSE(chart.series[1].marks[0].ringed);
  // More frames per second are better, less LPIPS is.
  const Chart speed = StudyCharts(points, "bases", qualities[2])[1].chart;
  ASSERT_EQ(speed.guides[0].marks.size(), 2u);
  EXPECT_NEAR(speed.guides[0].marks[0].x, 1e5 / 9000, 1e-9);
}

TEST(StudyPage, HoldsTablesDifferencesAndNotes) {
  const TemporaryFolder folder;
  {
    StudyLog log(folder.path());
    for (int seed = 0; seed < 2; ++seed) {
      StudyLine line = LineOf("a", seed, 30.5 + 2.2 * seed);
      line.minus = {"b"};
      log.Append(line);
      log.Append(LineOf("b", seed, 30 + 2 * seed));
    }
    log.Append(LineOf("b", 1, 32));
  }
  WriteStudyPage(folder.path(), folder / "charts");
  std::ostringstream text;
  text << std::ifstream(folder / "index.html").rdbuf();
  for (const std::string part : {"<h2>fox</h2>",
                                 "<h3>bases</h3>",
                                 "At step 10<",
                                 "At step 20<",
                                 ">31.60 ± 1.10<",
                                 ">a − b<",
                                 ">+0.60 ± 0.10<",
                                 "LPIPS (squeeze)",
                                 "Pareto front",
                                 "the later line counts: fox/b/1",
                                 "cosplat train-scene -s fox -m MODEL"})
    EXPECT_NE(text.str().find(part), std::string::npos) << part;
  EXPECT_EQ(text.str().find("src="), std::string::npos) << "loads something";
  EXPECT_TRUE(std::filesystem::exists(folder / "charts/fox-bases-psnr-gaussians.svg"));
  const TemporaryFolder empty;
  ExpectError([&] { WriteStudyPage(empty.path(), ""); }, {empty.path(), "no finished run"});
}

}  // namespace
}  // namespace cosplat::test

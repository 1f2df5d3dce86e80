// What `cosplat-study` makes of lines and of figures, without training anything.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <sstream>

#include "apps/study/runs/study_page.h"
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

// A list that was changed between two seeds does not split a setting.
TEST(StudyStatistics, APointIsShownAsItsLastLineSays) {
  StudyLine later = LineOf("a", 1, 31);
  later.label = "A";
  later.groups = {"pruning"};
  const std::vector<StudyPoint> points = PointsOf({LineOf("a", 0, 30), later});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].label, "A");
  EXPECT_EQ(points[0].groups, Strings{"pruning"});
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

// As on a disk that is full when a run ends and is not when the next one does.
TEST(StudyLines, ALineThatDoesNotFitLeavesNothing) {
  const TemporaryFolder folder;
  StudyLog log(folder.path());
  log.Append(LineOf("a", 0, 30));
  const auto size = std::filesystem::file_size(folder / "runs.jsonl");
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{rlim_t(size + 50), before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  ExpectError([&] { log.Append(LineOf("b", 0, 31)); }, {"runs.jsonl", "write failed"});
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(std::filesystem::file_size(folder / "runs.jsonl"), size);
  log.Append(LineOf("c", 0, 32));
  EXPECT_EQ(IdsIn(folder.path()), (Strings{"fox/a/0", "fox/c/0"}));
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

// Lines of versions that measured other files have other keys.
TEST(StudyLines, PublishedOnesAreRead) {
  for (const std::string folder : {"/docs/study", "/docs/study/0.2.0"}) {
    const std::vector<StudyLine> lines = ReadStudyLines(COSPLAT_SOURCE_DIR + folder).lines;
    const auto older = [](const StudyLine& l) { return l.checkpoints.back().count("vq_mb") > 0; };
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), older)) << folder;
    for (const StudyFigure& cost : CostsIn(PointsOf(lines))) EXPECT_NE(cost.key, "vq_mb");
  }
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

// Our settings first, means over all data where a system has them, nothing for what nobody states.
TEST(StudyPage, HoldsWhatOthersHavePublished) {
  const TemporaryFolder folder;
  const auto published = [](const std::string& data, double psnr) {
    StudyLine line;
    line.data = data, line.name = line.label = "Others";
    line.checkpoints = {{{"iterations", 0}, {"PSNR", psnr}}};
    return line;
  };
  {
    StudyLog log(folder.path());
    for (const std::string data : {"fox", "cat"}) {
      StudyLine line = LineOf("ours", 0, data == "fox" ? 30 : 33);
      line.data = data;
      log.Append(line);
    }
  }
  StudyLine one = published("fox", 29.5);
  one.name = one.label = "One";
  WritePublished(folder.path(), {published("fox", 31.25), one, published("cat", 32.75)});
  testing::internal::CaptureStdout();
  WriteStudyPage(folder.path(), "");
  const std::string printed = testing::internal::GetCapturedStdout();
  std::ostringstream page;
  page << std::ifstream(folder / "index.html").rdbuf();
  EXPECT_NE(page.str().find("Beside published figures"), std::string::npos);
  EXPECT_NE(page.str().find("2 runs, cosplat"), std::string::npos);
  size_t at = 0;
  for (const std::string row : {"| data | system | PSNR, dB |",
                                "| fox | ours | 30.00 |",
                                "| fox | Others (published) | 31.25 | - |",
                                "| fox | One (published) | 29.50 |",
                                "| cat | ours | 33.00 |",
                                "| cat | Others (published) | 32.75 |",
                                "| mean of 2 | ours | 31.50 |",
                                "| mean of 2 | Others (published) | 32.00 |"}) {
    at = printed.find(row, at);
    ASSERT_NE(at, std::string::npos) << row << " is not in its place in\n" << printed;
  }
  EXPECT_EQ(printed.find("| mean of 2 | One"), std::string::npos);
}

}  // namespace
}  // namespace cosplat::test

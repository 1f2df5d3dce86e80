#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "apps/charts/chart_scale.h"
#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/step_timer.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr uint64_t kSeed = 1;
constexpr size_t kUsualCount = 30000;
constexpr int kUsualSide = 512;  // px

// Rounds over all points, of which the fastest measurement counts; other load on the machine varies
// between rounds.
int Rounds(const BenchRun& run) { return run.quick ? 1 : 3; }

double StepMs(const BenchRun& run, const SyntheticView& view) {
  return run.quick ? TimeSteps(view, 1, 3).fastest_ms : TimeSteps(view, 2, 8).fastest_ms;
}

// Keeps the minimum of `ms` and mark.y, which is 0 in the first round.
void KeepFastest(double ms, Mark& mark) { mark.y = mark.y > 0 ? std::min(mark.y, ms) : ms; }

// Exponent of the growth of y with x between two marks: 1 is linear.
double Slope(const Mark& from, const Mark& to) {
  return std::log(to.y / from.y) / std::log(to.x / from.x);
}

// Over the whole range, and between the two largest.
OrderedJson Slopes(const std::vector<Mark>& marks) {
  return {{"slope", Slope(marks.front(), marks.back())},
          {"last_slope", Slope(marks[marks.size() - 2], marks.back())}};
}

// A line through the last mark, proportional to x: a steeper curve grows superlinearly.
ChartSeries Proportional(const std::vector<Mark>& marks) {
  const Mark &first = marks.front(), &last = marks.back();
  const double x = std::max(first.x, last.x * first.y / last.y);
  char name[64];
  std::snprintf(name,
                sizeof name,
                "in proportion (measured: slope %.2f, at the end %.2f)",
                Slope(first, last),
                Slope(marks[marks.size() - 2], last));
  return {name, {{x, last.y * x / last.x, ""}, last}};
}

BenchSeries StepSeries(const std::string& key,
                       const std::string& title,
                       const Axis& x,
                       std::vector<Mark> marks) {
  BenchSeries s;
  s.key = key;
  s.statistic = "fastest step";
  s.chart = {Chart::Kind::kLines, title, x, {"training step", "ms", true}, {}, {}};
  s.chart.series = {{"training step", std::move(marks)}};
  return s;
}

BenchSeries AgainstGaussians(const BenchRun& run) {
  std::vector<size_t> counts{1000, 3000, 10000, 30000, 100000, 300000, 1000000};
  if (run.quick) counts = {1000, 10000, 50000};
  std::vector<Mark> marks;
  for (const size_t count : counts) marks.push_back({double(count), 0, ""});
  for (int round = 0; round < Rounds(run); ++round)
    for (Mark& mark : marks) {
      run.progress("training step, " + WithThousands(size_t(mark.x)) + " Gaussians");
      KeepFastest(StepMs(run, MakeSyntheticView(size_t(mark.x), kUsualSide, kUsualSide, kSeed)),
                  mark);
    }
  BenchSeries s = StepSeries("step_gaussians",
                             "Training step against the number of Gaussians",
                             {"Gaussians, degree 3", "", true},
                             marks);
  s.explanation =
      "A training step on a 512x512 image that the Gaussians cover equally often whatever their "
      "number; the dashed line is in proportion to it.";
  s.chart.guides = {Proportional(marks)};
  s.more = Slopes(marks);
  return s;
}

BenchSeries AgainstPixels(const BenchRun& run) {
  std::vector<std::array<int, 2>> sizes{
      {128, 128}, {256, 256}, {512, 512}, {1024, 576}, {1280, 720}, {1920, 1080}};
  if (run.quick) sizes = {{128, 128}, {256, 256}, {512, 512}};
  std::vector<Mark> marks;
  for (const auto& [width, height] : sizes)
    marks.push_back({double(width) * height, 0, SizeText(width, height)});
  for (int round = 0; round < Rounds(run); ++round)
    for (size_t i = 0; i < sizes.size(); ++i) {
      run.progress("training step, " + marks[i].label + " pixels");
      const auto [width, height] = sizes[i];
      KeepFastest(StepMs(run, MakeSyntheticView(kUsualCount, width, height, kSeed)), marks[i]);
    }
  BenchSeries s = StepSeries(
      "step_pixels", "Training step against the size of the image", {"pixels", "", true}, marks);
  s.explanation =
      "A training step of 30,000 Gaussians that grow with the image; the dashed line is in "
      "proportion to its pixels.";
  s.chart.guides = {Proportional(marks)};
  s.more = Slopes(marks);
  return s;
}

BenchSeries StepsAsTrained(const BenchRun& run) {
  std::vector<std::array<int, 2>> sizes{{400, 400}, {800, 800}, {1600, 1064}};
  if (run.quick) sizes = {{100, 100}, {200, 200}};
  std::vector<Mark> marks;
  std::vector<SyntheticView> views;
  for (const auto& [width, height] : sizes) {
    views.push_back(MakeTrainedView(width, height, kSeed));
    marks.push_back({double(width) * height,
                     0,
                     SizeText(width, height) + ", " + WithThousands(views.back().start.size())});
  }
  for (int round = 0; round < Rounds(run); ++round)
    for (size_t i = 0; i < views.size(); ++i) {
      run.progress("training step as trained, " + marks[i].label);
      KeepFastest(StepMs(run, views[i]), marks[i]);
    }
  BenchSeries s = StepSeries("step_trained",
                             "Training step at published sizes, splats as training leaves them",
                             {"pixels", "", true},
                             marks);
  s.explanation =
      "As many Gaussians per pixel as a chair trained at 800x800 ends with (beside the points), "
      "half of them needles thinner than a pixel; the dashed line is in proportion to the pixels.";
  s.chart.guides = {Proportional(marks)};
  s.more = Slopes(marks);
  return s;
}

BenchSeries AgainstThreads(const BenchRun& run) {
  using tbb::global_control;
  const int all = int(global_control::active_value(global_control::max_allowed_parallelism));
  std::vector<Mark> marks;
  for (int threads = 1; threads < all; threads *= 2) marks.push_back({double(threads), 0, ""});
  marks.push_back({double(all), 0, ""});
  const SyntheticView view = MakeSyntheticView(kUsualCount, kUsualSide, kUsualSide, kSeed);
  for (int round = 0; round < Rounds(run); ++round)
    for (Mark& mark : marks) {
      run.progress("training step, threads: " + ShortNumber(mark.x));
      const global_control limit(global_control::max_allowed_parallelism, size_t(mark.x));
      KeepFastest(StepMs(run, view), mark);
    }
  for (Mark& mark : marks) mark.label = ShortNumber(marks[0].y / mark.y) + "x";
  BenchSeries s =
      StepSeries("step_threads", "Training step against threads", {"threads", "", true}, marks);
  s.explanation =
      "A training step of 30,000 Gaussians on a 512x512 image; beside each point how many times "
      "faster than one thread, and dashed what as many times as threads would be.";
  s.chart.guides = {
      {"ideal", {{1, marks[0].y, ""}, {marks.back().x, marks[0].y / marks.back().x, ""}}}};
  s.more = {{"ratio", marks[0].y / marks.back().y}};
  return s;
}

}  // namespace

std::vector<BenchSeries> MeasureSteps(const BenchRun& run) {
  return {AgainstGaussians(run), AgainstPixels(run), StepsAsTrained(run), AgainstThreads(run)};
}

}  // namespace cosplat

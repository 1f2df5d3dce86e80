#include <tbb/global_control.h>

#include <algorithm>
#include <limits>

#include "apps/study/bench/bench_scene.h"
#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/measure.h"
#include "apps/study/bench/step_timer.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Gaussians and the views that they are rendered for.
struct Drawn {
  std::string name;
  Gaussians gaussians;
  std::vector<TrainFrame> frames;
};

std::string NameOf(const std::string& scene, const Gaussians& g, const Camera& camera) {
  return scene + ", " + WithThousands(g.size()) + " at " + SizeText(camera.width, camera.height);
}

struct AccuracyCharts {
  BenchSeries steps, runs;
};

AccuracyCharts EmptyAccuracyCharts() {
  AccuracyCharts charts;
  charts.steps.key = "accuracy";
  charts.steps.explanation =
      "What a step costs and how good the result is on held-out views at full size, by the divisor "
      "of the training images (-r) and the number of steps (beside the points).";
  charts.steps.statistic =
      "step after the run, the fastest round of several; mean PSNR of the held-out views";
  charts.steps.chart = {Chart::Kind::kPoints,
                        "Speed of a step against accuracy",
                        {"training step", "ms", true},
                        {"held-out PSNR", "dB"},
                        {},
                        {}};
  charts.runs.key = "accuracy_time";
  charts.runs.explanation =
      "The same runs against the time that they took: the upper left is where one wants to be.";
  charts.runs.statistic = "one run each; mean PSNR of the held-out views";
  charts.runs.chart = {Chart::Kind::kLines,
                       "Training time against accuracy",
                       {"training loop", "s", true},
                       {"held-out PSNR", "dB"},
                       {},
                       {}};
  return charts;
}

struct TrainingRun {
  TrainingChoice choice;
  TrainedScene trained;
  double step_ms = std::numeric_limits<double>::infinity();
};

// Runs with the same divisor are consecutive, from short to long.
std::vector<TrainingRun> TrainAll(const BenchRun& run, const BenchScene& scene) {
  std::vector<int> lengths{250, 500, 1000, 2000}, divisors{1, 2, 4};
  if (run.quick) lengths = {40, 80}, divisors = {1, 2};
  std::vector<TrainingRun> runs;
  for (const int divisor : divisors)
    for (const int iterations : lengths) {
      run.progress("training " + scene.name + ", -r " + std::to_string(divisor) + ", " +
                   WithThousands(size_t(iterations)) + " steps");
      const TrainingChoice choice{divisor, iterations};
      runs.push_back({choice, TrainBenchScene(scene, choice)});
    }
  for (int round = 0; round < (run.quick ? 1 : 3); ++round)
    for (TrainingRun& r : runs)
      r.step_ms =
          std::min(r.step_ms, StepMs(scene, r.choice, r.trained.gaussians, run.quick ? 3 : 20));
  return runs;
}

void AddRuns(const BenchScene& scene,
             const std::vector<TrainingRun>& runs,
             AccuracyCharts& charts) {
  std::vector<ChartSeries>&steps = charts.steps.chart.series, &times = charts.runs.chart.series;
  for (const TrainingRun& r : runs) {
    const std::string name = scene.name + ", -r " + std::to_string(r.choice.divisor);
    if (steps.empty() || steps.back().name != name) {
      steps.push_back({name, {}});
      times.push_back({name, {}});
    }
    const std::string label = WithThousands(size_t(r.choice.iterations));
    steps.back().marks.push_back({r.step_ms, r.trained.psnr, label});
    times.back().marks.push_back({r.trained.seconds, r.trained.psnr, label});
  }
}

// Result of the longest run on full-size images.
Gaussians BestOf(std::vector<TrainingRun>& runs) {
  TrainingRun* best = &runs[0];
  for (TrainingRun& r : runs)
    if (r.choice.divisor == 1 && r.choice.iterations > best->choice.iterations) best = &r;
  return std::move(best->trained.gaussians);
}

// Seconds per view spent in the blend loop on one thread.
double BlendSeconds(const Gaussians& g, const Camera& camera, int repeats) {
  using tbb::global_control;
  const global_control one_thread(global_control::max_allowed_parallelism, 1);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    rasterizer->times = {};
    rasterizer->Forward(ViewOf(g), g.basis, camera, {{0, 0, 0}, g.degree}, image, *tape);
    best = std::min(best, rasterizer->times.seconds[size_t(Phase::kBlend)]);
  }
  return best;
}

std::vector<BenchSeries> MeasurePairs(const BenchRun& run, const std::vector<Drawn>& all) {
  constexpr size_t kViews = 4;
  ChartSeries evaluated{"evaluated", {}}, contributing{"contribute 1/255 or more", {}};
  ChartSeries evaluated_ns = evaluated, contributing_ns = contributing;
  for (const Drawn& drawn : all) {
    run.progress("pairs, " + drawn.name);
    PairCounts sum;
    double seconds = 0, pixels = 0;
    for (size_t i = 0; i < std::min(kViews, drawn.frames.size()); ++i) {
      const Camera& camera = drawn.frames[i].camera;
      const PairCounts counts = CountPairs(drawn.gaussians, camera);
      sum.evaluated += counts.evaluated;
      sum.contributing += counts.contributing;
      pixels += double(camera.width) * camera.height;
      seconds += BlendSeconds(drawn.gaussians, camera, run.quick ? 2 : 6);
    }
    evaluated.marks.push_back({double(sum.evaluated) / pixels, 0, drawn.name});
    contributing.marks.push_back({double(sum.contributing) / pixels, 0, drawn.name});
    evaluated_ns.marks.push_back({1e9 * seconds / double(sum.evaluated), 0, drawn.name});
    contributing_ns.marks.push_back({1e9 * seconds / double(sum.contributing), 0, drawn.name});
  }
  BenchSeries pairs, times;
  pairs.key = "pairs";
  pairs.explanation =
      "Splats that the blend loop works on per pixel (those that reach its block of 4x4, before "
      "the "
      "block is opaque), and those that add 1/255 or more to the pixel.";
  pairs.statistic = "mean over pixels";
  pairs.chart = {Chart::Kind::kBars,
                 "Pairs of pixel and splat in whole views",
                 {"splats per pixel", ""},
                 {},
                 {evaluated, contributing},
                 {}};
  times.key = "pair_times";
  times.explanation =
      "Time of the forward blend loop per pair of a whole view, on one thread; compare with the "
      "dense tile's.";
  times.statistic = "fastest render of each view";
  times.chart = {Chart::Kind::kBars,
                 "Blend loop in whole views, forward",
                 {"time per pair", "ns"},
                 {},
                 {evaluated_ns, contributing_ns},
                 {}};
  return {pairs, times};
}

BenchSeries MeasurePhases(const BenchRun& run, const std::vector<Drawn>& all) {
  BenchSeries s;
  s.key = "phases";
  s.explanation = "Where the time of a training step goes, all threads.";
  s.statistic = "mean step";
  s.chart = {Chart::Kind::kBars, "Phases of a training step", {"time", "ms"}, {}, {}, {}};
  for (const Drawn& drawn : all) {
    run.progress("phases, " + drawn.name);
    const StepTimes times = run.quick ? TimeSteps(drawn.frames, drawn.gaussians, 1, 5)
                                      : TimeSteps(drawn.frames, drawn.gaussians, 5, 40);
    ChartSeries series{drawn.name, {}};
    for (size_t i = 0; i < kPhaseNames.size(); ++i)
      if (Phase(i) != Phase::kPose)  // avatars only
        series.marks.push_back({1e3 * times.mean_phases.seconds[i], 0, kPhaseNames[i]});
    s.chart.series.push_back(series);
    s.more["ms_per_step"][drawn.name] = times.mean_ms;
  }
  return s;
}

Drawn LargeSynthetic(const BenchRun& run) {
  SyntheticView view =
      run.quick ? MakeSyntheticView(20000, 256, 256, 2) : MakeSyntheticView(200000, 960, 540, 2);
  const std::string name = NameOf("random", view.start, view.frame.camera);
  return {name, std::move(view.start), {view.frame}};
}

Drawn AsTrained(const BenchRun& run) {
  const int side = run.quick ? 200 : 800;
  SyntheticView view = MakeTrainedView(side, side, 2);
  const std::string name = NameOf("as trained", view.start, view.frame.camera);
  return {name, std::move(view.start), {view.frame}};
}

}  // namespace

std::vector<BenchSeries> MeasureScenes(const BenchRun& run, const std::vector<BenchScene>& scenes) {
  AccuracyCharts accuracy = EmptyAccuracyCharts();
  std::vector<Drawn> drawn;
  for (const BenchScene& scene : scenes) {
    std::vector<TrainingRun> runs = TrainAll(run, scene);
    AddRuns(scene, runs, accuracy);
    Gaussians g = BestOf(runs);
    const std::string name = NameOf(scene.name, g, scene.train[0].camera);
    drawn.push_back({name, std::move(g), scene.train});
  }
  drawn.push_back(LargeSynthetic(run));
  drawn.push_back(AsTrained(run));
  std::vector<BenchSeries> series = MeasurePairs(run, drawn);
  series.push_back(MeasurePhases(run, drawn));
  series.push_back(accuracy.steps);
  series.push_back(accuracy.runs);
  return series;
}

}  // namespace cosplat

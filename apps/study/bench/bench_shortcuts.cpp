#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <string>

#include "apps/study/bench/bench_scene.h"
#include "apps/study/bench/bench_series.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// A parameter that is varied on its own; the default (TrainSettings) is in every group.
struct Group {
  const char* name;
  const char* default_label;
};
constexpr Group kGroups[] = {{"exponential of degree", "5"}, {"Adam on", "drawn"}};
static_assert(kMaxExpDegree == 5);

struct Variant {
  size_t group;
  std::string label;
  TrainingChoice choice;
  std::vector<double> psnr = {};  // per seed, dB
  double step_ms = std::numeric_limits<double>::infinity();
};

// The first one is the default.
std::vector<Variant> MakeVariants(int iterations) {
  const TrainingChoice base{1, iterations};
  std::vector<Variant> variants{{0, kGroups[0].default_label, base}};
  for (int degree = kMinExpDegree; degree < kMaxExpDegree; ++degree) {
    variants.push_back({0, std::to_string(degree), base});
    variants.back().choice.shortcuts.exp_degree = degree;
  }
  variants.push_back({1, "all", base});
  variants.back().choice.shortcuts.adam_on = AdamOn::kAll;
  return variants;
}

std::string NameOf(const Variant& v) { return std::string(kGroups[v.group].name) + " " + v.label; }

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}
// Sample standard deviation of one value; needs at least two values.
double Deviation(const std::vector<double>& values) {
  const double mean = Mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / double(values.size() - 1));
}

// Fills in `psnr`. Returns the Gaussians of the default variant with the first seed.
Gaussians TrainVariants(const BenchRun& run,
                        const BenchScene& scene,
                        int seeds,
                        std::vector<Variant>& variants) {
  Gaussians first;
  for (int seed = 0; seed < seeds; ++seed)
    for (Variant& v : variants) {
      run.progress("training " + scene.name + ", " + NameOf(v) + ", seed " + std::to_string(seed));
      v.choice.seed = uint64_t(seed);
      TrainedScene trained = TrainBenchScene(scene, v.choice);
      v.psnr.push_back(trained.psnr);
      if (first.size() == 0) first = std::move(trained.gaussians);
    }
  return first;
}

// Fills in `step_ms`, with all steps on the same Gaussians.
void TimeVariants(const BenchRun& run,
                  const BenchScene& scene,
                  const Gaussians& g,
                  std::vector<Variant>& variants) {
  // Many short measurements, as the differences are small and a quiet moment suffices.
  const int rounds = run.quick ? 1 : 25, steps = run.quick ? 3 : 8;
  for (int round = 0; round < rounds; ++round)
    for (Variant& v : variants) {
      run.progress("training step, " + scene.name + ", " + NameOf(v));
      v.step_ms = std::min(v.step_ms, StepMs(scene, v.choice, g, steps));
    }
}

BenchSeries EmptySeries(const std::string& key, const BenchScene& scene, int iterations) {
  BenchSeries s;
  s.key = key;
  s.explanation =
      "What each shortcut of the training step gains in time and costs in accuracy, all else as it "
      "is by default: the degree of the polynomial for the exponential, and Adam on all Gaussians "
      "or, put off for the others, on those drawn.";
  s.statistic =
      "step: fastest of several rounds, on the same Gaussians; PSNR: mean over the held-out views "
      "and over seeds, psnr_deviation being that of one seed";
  s.chart = {
      Chart::Kind::kPoints,
      "Shortcuts of the step, " + scene.name + ", " + WithThousands(size_t(iterations)) + " steps",
      {"training step", "ms"},
      {"held-out PSNR, mean over seeds", "dB"},
      {},
      {}};
  for (const Group& group : kGroups) s.chart.series.push_back({group.name, {}});
  return s;
}

BenchSeries MeasureScene(const BenchRun& run, const BenchScene& scene, const std::string& key) {
  const int iterations = run.quick ? 20 : 1000, seeds = run.quick ? 2 : 4;
  std::vector<Variant> variants = MakeVariants(iterations);
  const Gaussians g = TrainVariants(run, scene, seeds, variants);
  TimeVariants(run, scene, g, variants);
  BenchSeries s = EmptySeries(key, scene, iterations);
  s.more = {{"iterations", iterations}, {"seeds", seeds}};
  for (const Variant& v : variants) {
    s.chart.series[v.group].marks.push_back({v.step_ms, Mean(v.psnr), v.label});
    s.more["psnr_deviation"][NameOf(v)] = Deviation(v.psnr);
  }
  for (size_t i = 1; i < std::size(kGroups); ++i)
    s.chart.series[i].marks.push_back(
        {variants[0].step_ms, Mean(variants[0].psnr), kGroups[i].default_label});
  return s;
}

}  // namespace

std::vector<BenchSeries> MeasureShortcuts(const BenchRun& run,
                                          const std::vector<BenchScene>& scenes) {
  std::vector<BenchSeries> series;
  for (const BenchScene& scene : scenes)
    series.push_back(MeasureScene(run, scene, series.empty() ? "shortcuts" : "shortcuts_given"));
  return series;
}

}  // namespace cosplat

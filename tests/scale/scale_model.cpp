// cosplat_scale_model FOLDER ONE_RANK.json PIXELS [MORE_RANKS.json...]: calculates the time of a
// step on 1 to 64 ranks from the statistics of a run on one, writes its charts into FOLDER, and
// prints what it says of runs on more ranks beside what they took.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include "apps/charts/svg_chart.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "tests/scale/model.h"

namespace cosplat::scale {
namespace {

constexpr double kGigabit = 1e9 / 8;  // bytes per second

void WriteCharts(const std::string& folder, const Measured& measured) {
  for (const double gigabits : {1.0, 25.0}) {
    const std::string link = gigabits == 1 ? "1" : "25";
    Chart chart;
    chart.title = "Views per second on " + link + " Gb/s, 4 views a step and rank";
    chart.x = {"ranks, of one core each", "", true};
    chart.y = {"views per second", "", true};
    for (const double gaussians : {1e6, 1e7, 1e8}) {
      ChartSeries series{gaussians == 1e6   ? "10^6 Gaussians"
                         : gaussians == 1e7 ? "10^7"
                                            : "10^8",
                         {}};
      for (double ranks = 1; ranks <= 64; ranks *= 2) {
        const Training training = LargeTraining(measured, gaussians, 4 * ranks);
        const StepTime time = TimeOf(measured, training, {ranks, gigabits * kGigabit});
        series.marks.push_back({ranks, training.batch / time.total(), "", 0, 0, false});
        std::printf(
            "%2s Gb/s  10^%.0f Gaussians  %2.0f ranks  step %8.3f s: drawing %7.3f, own share "
            "%7.3f, exchange %8.3f  %9.1f MB\n",
            link.c_str(),
            std::log10(gaussians),
            ranks,
            time.total(),
            time.drawing,
            time.own_share,
            time.exchange,
            1e-6 * time.bytes);
      }
      chart.series.push_back(series);
    }
    WriteFileAtomically(folder + "/scale_" + link + "gb.svg", ToSvg(chart));
  }
}

// Ranks of one machine: what they exchange they copy, without a link.
void Compare(const Measured& measured, const std::string& stats_json) {
  const std::vector<char> bytes = ReadFile(stats_json);
  const Json json = ParseJson(stats_json, std::string(bytes.begin(), bytes.end()));
  const JsonField stats(stats_json, json);
  const JsonField batch = stats["batch"];
  const double steps = batch["steps"].Number(), ranks = batch["ranks"].Number();
  Training training = TrainingOf(measured);
  training.assembled = batch["numbers_assembled"].Number() / steps;
  training.moved = batch["numbers_handed_over"].Number() / steps / (ranks > 1 ? 1 - 1 / ranks : 1);
  const StepTime time = TimeOf(measured, training, {ranks, HUGE_VAL, 0});
  std::printf(
      "%d ranks, processor seconds of one for a step: %.3f calculated (drawing %.3f, own share "
      "%.3f, "
      "exchange %.3f), %.3f taken; sent %.2f MB calculated, %.2f MB counted\n",
      batch["ranks"].Integer(),
      time.total(),
      time.drawing,
      time.own_share,
      time.exchange,
      stats["cpu_seconds"].Number() / steps,
      1e-6 * time.bytes,
      1e-6 * batch["bytes_sent"].Number() / steps);
}

int Run(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "cosplat_scale_model FOLDER ONE_RANK.json PIXELS [MORE_RANKS.json...]\n");
    return 2;
  }
  const Measured m = MeasuredIn(argv[2], std::atof(argv[3]));
  std::printf(
      "measured: %.1f ns per Gaussian, %.1f ns per drawn one, %.1f ns per pixel, %.1f ns per "
      "summed one, %.1f ns per updated one; a view draws %.3f of them, a step updates %.3f\n",
      1e9 * m.per_gaussian,
      1e9 * m.per_drawn,
      1e9 * m.per_pixel,
      1e9 * m.per_summed,
      1e9 * m.per_updated,
      m.drawn,
      m.updated);
  for (int i = 2; i < argc; ++i)
    if (i != 3) Compare(m, argv[i]);
  WriteCharts(argv[1], m);
  return 0;
}

}  // namespace
}  // namespace cosplat::scale

int main(int argc, char** argv) {
  try {
    return cosplat::scale::Run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "cosplat_scale_model: %s\n", e.what());
    return 2;
  }
}

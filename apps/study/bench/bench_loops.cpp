#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/dense_tile.h"
#include "apps/study/bench/machine.h"

namespace cosplat {
namespace {

struct LoopFigures {
  std::string name;
  BlendTimes blend;
  double fma_gflops = 0;
};

std::vector<LoopFigures> MeasureTargets(const BenchRun& run) {
  const int batches = run.quick ? 5 : 20;
  std::vector<LoopFigures> figures;
  for (const SimdTarget& target : SimdTargets()) {
    run.progress("blend loop, " + target.name);
    const OnlySimdTarget only(target);
    figures.push_back({target.name, MeasureBlend(batches), FmaPeakGflops(4 * batches)});
  }
  return figures;
}

BenchSeries BlendSeries(const BlendTimes& scalar, const std::vector<LoopFigures>& figures) {
  BenchSeries s;
  s.key = "blend";
  s.explanation =
      "Time of the blend loop per pixel and splat, on one core and a dense tile (128 splats on "
      "16x16 pixels, no early stop), by instruction set; less is better.";
  s.statistic = "fastest batch";
  s.chart = {
      Chart::Kind::kBars, "Blend loop, dense tile", {"time per pair", "ns", true}, {}, {}, {}};
  ChartSeries forward{"forward", {}}, backward{"backward", {}};
  for (const LoopFigures& f : figures) {
    forward.marks.push_back({f.blend.forward_ns, 0, f.name});
    backward.marks.push_back({f.blend.backward_ns, 0, f.name});
  }
  forward.marks.push_back({scalar.forward_ns, 0, "plain floats"});
  backward.marks.push_back({scalar.backward_ns, 0, "plain floats"});
  s.chart.series = {forward, backward};
  return s;
}

BenchSeries PeakSeries(const std::vector<LoopFigures>& figures) {
  BenchSeries s;
  s.key = "fma";
  s.explanation =
      "What one core computes at most (fused multiply-adds alone) and what the blend loop needs of "
      "it, at 25 operations per pair forward and 60 backward.";
  s.statistic = "fastest batch";
  s.chart = {Chart::Kind::kBars,
             "Arithmetic of one core",
             {"floating-point operations", "GFLOP/s"},
             {},
             {},
             {}};
  ChartSeries peak{"FMA peak", {}}, forward{"blend forward", {}}, backward{"blend backward", {}};
  for (const LoopFigures& f : figures) {
    peak.marks.push_back({f.fma_gflops, 0, f.name});
    forward.marks.push_back({kBlendForwardFlops / f.blend.forward_ns, 0, f.name});
    backward.marks.push_back({kBlendBackwardFlops / f.blend.backward_ns, 0, f.name});
  }
  s.chart.series = {peak, forward, backward};
  return s;
}

BenchSeries StreamSeries(const BenchRun& run) {
  constexpr size_t kMegabyte = 1 << 20;
  const size_t bytes = (run.quick ? 256 : 768) * kMegabyte;
  const int batches = run.quick ? 3 : 40;
  run.progress("memory stream");
  BenchSeries s;
  s.key = "stream";
  s.explanation =
      "Bytes per second between the cores and memory when nothing fits a cache (two arrays read, "
      "one written): the ceiling of the optimiser.";
  s.statistic = "fastest pass";
  s.chart = {Chart::Kind::kBars, "Memory stream", {"bytes moved", "GB/s"}, {}, {}, {}};
  s.chart.series = {{"stream",
                     {{StreamGbs(bytes, false, batches), 0, "one core"},
                      {StreamGbs(bytes, true, batches), 0, "all cores"}}}};
  s.more = {{"array_bytes", bytes}};
  return s;
}

}  // namespace

std::vector<BenchSeries> MeasureLoops(const BenchRun& run, OrderedJson& head) {
  run.progress("blend loop, float");
  const BlendTimes scalar = MeasureScalarBlend(run.quick ? 3 : 10);
  const std::vector<LoopFigures> figures = MeasureTargets(run);
  std::vector<BenchSeries> series{
      BlendSeries(scalar, figures), PeakSeries(figures), StreamSeries(run)};
  head["blend_forward_ns_per_pixel_splat"] = figures[0].blend.forward_ns;
  head["blend_backward_ns_per_pixel_splat"] = figures[0].blend.backward_ns;
  head["fma_peak_gflops"] = figures[0].fma_gflops;
  head["stream_gbs"] = series.back().chart.series[0].marks[1].x;
  return series;
}

}  // namespace cosplat

#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/held_memory.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr uint64_t kMemorySeed = 1;
constexpr int kMemorySide = 512;  // px

BenchSeries EmptySeries() {
  BenchSeries s;
  s.key = "memory";
  s.explanation =
      "What a training run holds per Gaussian of degree 3, part by part, beyond what grows with "
      "the image.";
  s.statistic = "capacity of all buffers after a run";
  s.chart = {Chart::Kind::kBars, "Memory of training", {"bytes per Gaussian", "B"}, {}, {}, {}};
  return s;
}

void AddRun(const std::string& name,
            const std::vector<MemoryPart>& parts,
            size_t gaussians,
            BenchSeries& s) {
  const std::string full = name + ", " + WithThousands(gaussians);
  ChartSeries bars{full, {}};
  for (const MemoryPart& part : parts)
    if (part.of == MemoryOf::kGaussians)
      bars.marks.push_back({double(part.bytes) / double(gaussians), 0, part.name});
  s.chart.series.push_back(bars);
  s.more["bytes_per_gaussian"][full] =
      double(SumOf(parts, MemoryOf::kGaussians)) / double(gaussians);
  s.more["bytes_of_pixels"][full] = SumOf(parts, MemoryOf::kPixels);
}

}  // namespace

BenchSeries MeasureMemory(const BenchRun& run, const std::vector<BenchScene>& scenes) {
  BenchSeries s = EmptySeries();
  const size_t count = run.quick ? 20000 : 300000;
  run.progress("memory, " + WithThousands(count) + " Gaussians");
  AddRun("random",
         MemoryOfSteps(MakeSyntheticView(count, kMemorySide, kMemorySide, kMemorySeed), 3),
         count,
         s);
  for (const BenchScene& scene : scenes) {
    run.progress("memory, " + scene.name);
    const TrainedScene trained = TrainBenchScene(scene, {1, run.quick ? 40 : 1000});
    AddRun(scene.name, trained.memory, trained.gaussians.size(), s);
  }
  run.progress("memory, resident");
  s.more["resident_bytes_per_gaussian"] =
      run.quick ? ResidentBytesPerGaussian(10000, 50000, kMemorySide)
                : ResidentBytesPerGaussian(100000, 500000, kMemorySide);
  return s;
}

}  // namespace cosplat

// cosplat-study bench: measures the CPU back end on this machine; figures and charts.
#include <tbb/global_control.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "apps/cosplat/run/progress_bar.h"
#include "apps/study/bench/bench_results.h"
#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/machine.h"
#include "apps/study/commands.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

struct BenchCommand {
  std::string out, scene, splats;
  int resolution = 1;
  bool quick = false, quiet = false;
};

// Fails before minutes of measurements rather than after them.
void CheckWritable(const std::string& folder) {
  MakeDirectories(folder);
  if (access(folder.c_str(), W_OK) != 0) throw Error(folder, "cannot be written to");
}

std::vector<BenchScene> ScenesOf(const BenchCommand& o) {
  std::vector<BenchScene> scenes;
  if (!o.scene.empty()) scenes.push_back(LoadBenchScene(o.scene, o.resolution));
  scenes.insert(scenes.begin(), o.quick ? MakeHeadScene(96, 15) : MakeHeadScene(256, 50));
  return scenes;
}

OrderedJson MachineJson() {
  using tbb::global_control;
  return {{"cpu", CpuName()},
          {"simd", SimdTargets().at(0).name},
          {"threads", global_control::active_value(global_control::max_allowed_parallelism)}};
}

void Append(std::vector<BenchSeries> more, std::vector<BenchSeries>& all) {
  for (BenchSeries& series : more) all.push_back(std::move(series));
}

void Bench(const BenchCommand& o) {
  const std::vector<BenchScene> scenes = ScenesOf(o);
  std::optional<OrbitSubject> orbit;
  if (!o.splats.empty()) orbit = LoadOrbit(o.splats, o.quick);
  CheckWritable(o.out);
  OrderedJson head = MachineJson();
  std::vector<BenchSeries> series;
  Image orbit_image;
  {
    constexpr int kParts = 6;
    ProgressBar bar("bench", kParts + orbit.has_value(), o.quiet);
    int done = 0;
    const BenchRun run{o.quick, [&](const std::string& detail) { bar.Update(done, detail); }};
    Append(MeasureLoops(run, head), series);
    ++done;
    const BenchSeries playback = MeasurePlayback(run, head);
    ++done;
    Append(MeasureSteps(run), series);
    ++done;
    series.push_back(playback);
    Append(MeasureScenes(run, scenes), series);
    ++done;
    Append(MeasureShortcuts(run, scenes), series);
    ++done;
    series.push_back(MeasureMemory(run, scenes));
    ++done;
    if (orbit) {
      OrbitResult result = MeasureOrbit(run, *orbit);
      series.push_back(std::move(result.series));
      orbit_image = std::move(result.first);
    }
  }
  if (orbit) WriteImage(o.out + "/orbit.png", orbit_image);
  WriteBench(o.out, head, series);
  if (!o.quiet)
    std::printf(
        "%s\n%zu charts: %s/index.html\n", head.dump(2).c_str(), series.size(), o.out.c_str());
}

}  // namespace

void AddBench(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("bench", "measure this machine: bench.json and charts of it");
  const auto o = std::make_shared<BenchCommand>();
  command->add_option("-o,--out", o->out, "folder to write")->required();
  command->add_flag("--quick", o->quick, "half a minute of coarse figures");
  command->add_option("-s,--source_path", o->scene, "photographs to measure on as well")
      ->default_str("");
  command->add_option("-r,--resolution", o->resolution, "divide the photographs' size by this")
      ->check(CLI::Range(1, 64));
  command
      ->add_option(
          "--splats", o->splats, "splat file to draw from all around as well (docs/files.md)")
      ->default_str("");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Bench(*o); });
}

}  // namespace cosplat

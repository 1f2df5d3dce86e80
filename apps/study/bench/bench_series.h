// `cosplat bench --splats`: how fast a file of splats is drawn from all around.
#pragma once

#include <string>
#include <vector>

#include "apps/study/bench/bench_results.h"
#include "apps/study/bench/bench_scene.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"

namespace cosplat {

struct OrbitSubject {
  std::string name;  // of the file
  Gaussians gaussians;
  std::vector<Camera> cameras;
};

// Reads a PLY file and stands cameras around its splats, looking level at their middle, -y up, at
// such a distance that the visible ones (but for a thousandth at either end) fill 90 % of the
// images' height on average. 1920x1080 px, a 30th of it when `quick`. Throws Error when nothing
// is to be seen.
OrbitSubject LoadOrbit(const std::string& path, bool quick);

struct OrbitResult {
  BenchSeries series;
  Image first;  // image of the first camera
};
OrbitResult MeasureOrbit(const BenchRun& run, const OrbitSubject& subject);

// `cosplat bench`: the blend loop beside what the machine can do.

// Time per pair on every instruction set, its share of the FMA peak, and the memory stream. Adds
// the figures of the instruction set in use to `head`.
std::vector<BenchSeries> MeasureLoops(const BenchRun& run, OrderedJson& head);

// `cosplat bench`: what a training run holds in memory.

// Bytes per Gaussian, part by part, of a synthetic view and of a run on each scene.
BenchSeries MeasureMemory(const BenchRun& run, const std::vector<BenchScene>& scenes);

// `cosplat bench`: frames per second of a moving avatar.

// Against the number of splats; adds avatar_fps, that of an avatar of the usual size, to `head`.
BenchSeries MeasurePlayback(const BenchRun& run, OrderedJson& head);

// `cosplat bench`: what is measured on images: speed against accuracy, the pairs that the
// blend loop looks at, and where a step's time goes.

std::vector<BenchSeries> MeasureScenes(const BenchRun& run, const std::vector<BenchScene>& scenes);

// `cosplat bench`: what each shortcut of the training step gains in time and costs in accuracy.

// A chart per scene: that of the first is `shortcuts`, that of a second one `shortcuts_given`.
std::vector<BenchSeries> MeasureShortcuts(const BenchRun& run,
                                          const std::vector<BenchScene>& scenes);

// `cosplat bench`: how the time of a training step grows.

// On synthetic views: against the number of Gaussians, of pixels and of threads.
std::vector<BenchSeries> MeasureSteps(const BenchRun& run);

}  // namespace cosplat

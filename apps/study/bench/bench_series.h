// `cosplat-study bench --splats`: rendering speed of a splat file on an orbit.
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

// Reads a PLY file and places cameras around its splats, looking horizontally at their centre, with
// -y up, at a distance at which the visible splats (without the outermost thousandth at either end)
// fill 90 % of the image height on average. 1920x1080 px, or a 30th of it if `quick`. Throws Error
// if no splat is visible.
OrbitSubject LoadOrbit(const std::string& path, bool quick);

struct OrbitResult {
  BenchSeries series;
  Image first;  // rendered from the first camera
};
OrbitResult MeasureOrbit(const BenchRun& run, const OrbitSubject& subject);

// `cosplat-study bench`: the blend loop compared with the machine's limits.
//
// Time per pixel-splat pair on every instruction set, its share of the FMA peak, and the memory
// bandwidth. Adds the figures of the instruction set in use to `head`.
std::vector<BenchSeries> MeasureLoops(const BenchRun& run, OrderedJson& head);

// `cosplat-study bench`: memory held by a training run.
//
// Bytes per Gaussian, by component, of a synthetic view and of a run on each scene.
BenchSeries MeasureMemory(const BenchRun& run, const std::vector<BenchScene>& scenes);

// `cosplat-study bench`: frame rate of an animated avatar.
//
// As a function of the number of splats; adds avatar_fps, for an avatar of typical size, to `head`.
BenchSeries MeasurePlayback(const BenchRun& run, OrderedJson& head);

// `cosplat-study bench`: measurements on images: speed against accuracy, the pairs that the blend
// loop evaluates, and the time per phase of a step.
std::vector<BenchSeries> MeasureScenes(const BenchRun& run, const std::vector<BenchScene>& scenes);

// `cosplat-study bench`: time gained and accuracy lost by each shortcut of the training step.
//
// One chart per scene: `shortcuts` for the first, `shortcuts_given` for a second one.
std::vector<BenchSeries> MeasureShortcuts(const BenchRun& run,
                                          const std::vector<BenchScene>& scenes);

// `cosplat-study bench`: scaling of the time of a training step.
//
// On synthetic views, with the number of Gaussians, of pixels and of threads.
std::vector<BenchSeries> MeasureSteps(const BenchRun& run);

}  // namespace cosplat

// `cosplat bench`: what a training run holds in memory.
#pragma once

#include "apps/study/bench/bench_results.h"
#include "apps/study/bench/bench_scene.h"

namespace cosplat {

// Bytes per Gaussian, part by part, of a synthetic view and of a run on each scene.
BenchSeries MeasureMemory(const BenchRun& run, const std::vector<BenchScene>& scenes);

}  // namespace cosplat

// `cosplat bench`: how the time of a training step grows.
#pragma once

#include <vector>

#include "apps/study/bench/bench_results.h"

namespace cosplat {

// On synthetic views: against the number of Gaussians, of pixels and of threads.
std::vector<BenchSeries> MeasureSteps(const BenchRun& run);

}  // namespace cosplat

// `cosplat bench`: what is measured on photographs: speed against accuracy, the pairs that the
// blend loop looks at, and where a step's time goes.
#pragma once

#include <vector>

#include "apps/study/bench/bench_results.h"
#include "apps/study/bench/bench_scene.h"

namespace cosplat {

std::vector<BenchSeries> MeasureScenes(const BenchRun& run, const std::vector<BenchScene>& scenes);

}  // namespace cosplat

// `cosplat bench`: what each shortcut of the training step gains in time and costs in accuracy.
#pragma once

#include <vector>

#include "apps/study/bench/bench_results.h"
#include "apps/study/bench/bench_scene.h"

namespace cosplat {

// A chart per scene: that of the first is `shortcuts`, that of a second one `shortcuts_given`.
std::vector<BenchSeries> MeasureShortcuts(const BenchRun& run,
                                          const std::vector<BenchScene>& scenes);

}  // namespace cosplat

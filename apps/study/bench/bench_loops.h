// `cosplat bench`: the blend loop beside what the machine can do.
#pragma once

#include <vector>

#include "apps/study/bench/bench_results.h"

namespace cosplat {

// Time per pair on every instruction set, its share of the FMA peak, and the memory stream. Adds
// the figures of the instruction set in use to `head`.
std::vector<BenchSeries> MeasureLoops(const BenchRun& run, OrderedJson& head);

}  // namespace cosplat

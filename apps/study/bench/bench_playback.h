// `cosplat bench`: frames per second of a moving avatar.
#pragma once

#include "apps/study/bench/bench_results.h"

namespace cosplat {

// Against the number of splats; adds avatar_fps, that of an avatar of the usual size, to `head`.
BenchSeries MeasurePlayback(const BenchRun& run, OrderedJson& head);

}  // namespace cosplat

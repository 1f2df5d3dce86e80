// Runs a body for indices or ranges on oneTBB's threads; for loops whose iterations are
// independent, so that the bits do not depend on the number of threads.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace cosplat {

// body(begin, end) for consecutive ranges of `grain` indices, the last one shorter: the same ranges
// for any number of threads. `grain`: some tens of microseconds of work.
template <class Body>
void ParallelForRanges(size_t count, size_t grain, const Body& body) {
  tbb::parallel_for(size_t(0), (count + grain - 1) / grain, [&](size_t chunk) {
    body(chunk * grain, std::min((chunk + 1) * grain, count));
  });
}

// body(i) for i in [0, count); the default grain suits a vertex, a face or a Gaussian.
template <class Body>
void ParallelFor(size_t count, const Body& body, size_t grain = 256) {
  ParallelForRanges(count, grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace cosplat

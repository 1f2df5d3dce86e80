// Runs body(i) for i in [0, count) on oneTBB's threads; for loops whose iterations are independent,
// so that the bits do not depend on the number of threads.
#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>

namespace cosplat {

// `grain`: iterations per task; some tens of microseconds of work for a vertex, a face or a
// Gaussian.
template <class Body>
void ParallelFor(size_t count, const Body& body, size_t grain = 256) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, grain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) body(i);
                    });
}

}  // namespace cosplat

// Timing for the measurements of this folder: a warm-up call, then the fastest of several batches,
// so that other load on the machine has little influence.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace cosplat {

inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Seconds per call of `f`: the fastest of `batches` batches of `calls` calls each.
template <class F>
double FastestSeconds(int batches, int calls, const F& f) {
  f();
  double best = std::numeric_limits<double>::infinity();
  for (int batch = 0; batch < batches; ++batch) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) f();
    best = std::min(best, SecondsSince(start) / calls);
  }
  return best;
}

}  // namespace cosplat

// The machine that a benchmark runs on: its names and its measured ceilings, which the blend loop
// and the optimiser are compared with (`cosplat bench`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

// "model name" of /proc/cpuinfo; "unknown" where there is none.
std::string CpuName();

// An instruction set that the loops are built for, by Highway's name: "AVX3_ZEN4", "AVX2", ...
struct SimdTarget {
  int64_t id = 0;
  std::string name;
};

// Those that this machine has, the one in use first.
std::vector<SimdTarget> SimdTargets();

// While it lives, every dispatched loop of the process runs on one of SimdTargets(). Not to be
// nested; no other thread may be drawing.
class OnlySimdTarget {
 public:
  explicit OnlySimdTarget(const SimdTarget& target);
  ~OnlySimdTarget();
  OnlySimdTarget(const OnlySimdTarget&) = delete;
  OnlySimdTarget& operator=(const OnlySimdTarget&) = delete;
};

// Fused multiply-adds of one core on the instruction set in use, 1e9 floating-point operations per
// second (two per multiply-add).
double FmaPeakGflops(int batches);

// Memory stream, 1e9 bytes per second: a[i] = b[i] + s c[i] over three arrays of `bytes` together,
// counting two reads and one write (McCalpin's STREAM). On one core, or on all that may be used.
double StreamGbs(size_t bytes, bool all_cores, int batches);

}  // namespace cosplat

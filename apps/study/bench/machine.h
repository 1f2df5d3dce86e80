// Name and measured peak performance of the machine that a benchmark runs on, as references for the
// blend loop and the optimiser (`cosplat-study bench`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

// "model name" in /proc/cpuinfo; "unknown" if there is none.
std::string CpuName();

// An instruction set that the loops are compiled for, by Highway's name: "AVX3_ZEN4", "AVX2", ...
struct SimdTarget {
  int64_t id = 0;
  std::string name;
};

// The instruction sets that this machine supports, the one in use first.
std::vector<SimdTarget> SimdTargets();

// While it exists, all dispatched loops of the process run on one of SimdTargets(). Must not be
// nested; no other thread may be rendering.
class OnlySimdTarget {
 public:
  explicit OnlySimdTarget(const SimdTarget& target);
  ~OnlySimdTarget();
  OnlySimdTarget(const OnlySimdTarget&) = delete;
  OnlySimdTarget& operator=(const OnlySimdTarget&) = delete;
};

// Fused multiply-add throughput of one core on the instruction set in use, in 1e9 floating-point
// operations per second (two per multiply-add).
double FmaPeakGflops(int batches);

// Memory bandwidth, 1e9 bytes per second: a[i] = b[i] + s c[i] over three arrays of `bytes` in
// total, counting two reads and one write (McCalpin's STREAM). On one core, or on all available
// cores.
double StreamGbs(size_t bytes, bool all_cores, int batches);

}  // namespace cosplat

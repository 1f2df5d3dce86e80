// Runs a kernel over elements on the host or on a device, from a single kernel source.
//
// A kernel is a struct of Views and numbers with `COSPLAT_HD void operator()(size_t i) const`,
// whose elements are independent: results are bit-identical for any number of threads. A device
// back end lists the kernels that are compiled for it (splat/device/cuda/kernels.cuh).
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <string>
#include <typeinfo>

#include "splat/base/error.h"
#include "splat/device/stream.h"

namespace cosplat {

// Parallel loops on oneTBB's threads, for independent iterations: results are bit-identical for any
// number of threads.

// body(begin, end) for consecutive ranges of `grain` indices (the last may be shorter), which are
// the same for any number of threads. `grain`: some tens of microseconds of work.
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

// How a device back end launches the kernel; null if it does not have it. Threads that each make
// something for the device register the same kernels again.
template <class Kernel>
struct KernelLaunch {
  using Function = void (*)(size_t n, Stream& stream, const Kernel& kernel);
  static inline std::atomic<Function> function = nullptr;

  static void Run(size_t n, Stream& stream, const Kernel& kernel) {
    const Function launch = function;
    if (!launch)
      throw Error("device", std::string("has no compiled kernel ") + typeid(Kernel).name());
    launch(n, stream, kernel);
  }
};

// kernel(i) for i < n.
template <class Kernel>
void ForEach(size_t n, Stream& stream, const Kernel& kernel) {
  if (!stream.on_host()) return KernelLaunch<Kernel>::Run(n, stream, kernel);
  ParallelFor(n, kernel);
}

// For kernels that process SIMD packs of elements on the host, by RunOnHost(n, kernel), compiled
// once per instruction set. A device runs Run<float>(kernel, Rows{i, 1}) in one thread per element.
template <class Kernel>
void ForEachRow(size_t n, Stream& stream, const Kernel& kernel) {
  if (!stream.on_host()) return KernelLaunch<Kernel>::Run(n, stream, kernel);
  RunOnHost(n, kernel);
}

}  // namespace cosplat

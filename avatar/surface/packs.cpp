// The kernels of avatar/surface/kernels/ on SIMD packs, compiled per instruction set and run in
// parallel with oneTBB.
#include <algorithm>
#include <cmath>

#include "splat/device/for_each.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "avatar/surface/packs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "avatar/surface/gather_rows.h"
#include "avatar/surface/kernels/embed.h"
#include "avatar/surface/kernels/surface.h"

COSPLAT_MATH_BEGIN

void PoseFaces(const PoseFacesKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}
void PoseVertices(const PoseVerticesKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}
void VerticesVjp(const VerticesVjpKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}
void FacesVjp(const FacesVjpKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}
void EmbedRange(const EmbedKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}
void EmbedVjpRange(const EmbedVjpKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}
void RigidEmbedRange(const RigidEmbedKernel& kernel, size_t begin, size_t end) {
  RunRange(kernel, begin, end);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(PoseFaces);
HWY_EXPORT(PoseVertices);
HWY_EXPORT(VerticesVjp);
HWY_EXPORT(FacesVjp);
HWY_EXPORT(EmbedRange);
HWY_EXPORT(EmbedVjpRange);
HWY_EXPORT(RigidEmbedRange);
}  // namespace math

namespace {

constexpr size_t kGrain = 512;  // a multiple of the lane count of every instruction set

// Calls run(kernel, begin, end), the variant for the processor, on ranges in parallel.
template <class Kernel, class Range>
void RunRanges(size_t n, const Kernel& kernel, const Range& run) {
  ParallelForRanges(n, kGrain, [&](size_t begin, size_t end) { run(kernel, begin, end); });
}

}  // namespace

using namespace math;  // for HWY_DYNAMIC_DISPATCH

void RunOnHost(size_t n, const PoseFacesKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(PoseFaces));
}
void RunOnHost(size_t n, const PoseVerticesKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(PoseVertices));
}
void RunOnHost(size_t n, const VerticesVjpKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(VerticesVjp));
}
void RunOnHost(size_t n, const FacesVjpKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(FacesVjp));
}
void RunOnHost(size_t n, const EmbedKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(EmbedRange));
}
void RunOnHost(size_t n, const EmbedVjpKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(EmbedVjpRange));
}
void RunOnHost(size_t n, const RigidEmbedKernel& kernel) {
  RunRanges(n, kernel, HWY_DYNAMIC_DISPATCH(RigidEmbedRange));
}

}  // namespace cosplat
#endif

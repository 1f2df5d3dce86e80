#include "avatar/surface/surface_packs.h"

#include <algorithm>
#include <cmath>

#include "avatar/surface/parallel_for.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "avatar/surface/surface_packs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "avatar/surface/gather_rows.h"
#include "avatar/surface/kernels/surface.h"

COSPLAT_MATH_BEGIN

void PoseFaces(const SurfaceArrays& s, size_t begin, size_t end) {
  RunRange(PoseFacesKernel{s}, begin, end);
}
void PoseVertices(const SurfaceArrays& s, size_t begin, size_t end) {
  RunRange(PoseVerticesKernel{s}, begin, end);
}
void VerticesVjp(
    const SurfaceArrays& s, const float* d_vertices, float* d_sums, size_t begin, size_t end) {
  RunRange(VerticesVjpKernel{s, d_vertices, d_sums}, begin, end);
}
void FacesVjp(
    const SurfaceArrays& s, const float* d_sums, float* d_corners, size_t begin, size_t end) {
  RunRange(FacesVjpKernel{s, d_sums, d_corners}, begin, end);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(PoseFaces);
HWY_EXPORT(PoseVertices);
HWY_EXPORT(VerticesVjp);
HWY_EXPORT(FacesVjp);
}  // namespace math

namespace {
constexpr size_t kGrain = 512;  // a multiple of every pack's lanes
}  // namespace

void LaunchPoseSurface(const SurfaceArrays& s) {
  using namespace math;
  ParallelForRanges(s.face_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(PoseFaces)(s, begin, end);
  });
  ParallelForRanges(s.vertex_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(PoseVertices)(s, begin, end);
  });
}

void LaunchPoseSurfaceVjp(const SurfaceArrays& s,
                          const float* d_vertices,
                          float* d_sums,
                          float* d_corners) {
  using namespace math;
  ParallelForRanges(s.vertex_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(VerticesVjp)(s, d_vertices, d_sums, begin, end);
  });
  ParallelForRanges(s.face_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(FacesVjp)(s, d_sums, d_corners, begin, end);
  });
}

}  // namespace cosplat
#endif

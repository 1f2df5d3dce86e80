#include "splat/cpu/launch.h"

#include <tbb/parallel_for.h>

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/cpu/launch.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/kernels/project.h"

COSPLAT_MATH_BEGIN

void ProjectRange(const WorldGaussians& gaussians,
                  const ViewParameters& view,
                  ProjectedSplat* splats,
                  size_t begin,
                  size_t end) {
  const ProjectKernel kernel{gaussians, view, splats};
  for (size_t i = begin; i < end; ++i) kernel(i);
}

void ProjectVjpRange(const WorldGaussians& gaussians,
                     const ViewParameters& view,
                     const ProjectedSplat* splats,
                     const SplatGradient* d_splats,
                     const WorldGradients& gradients,
                     size_t begin,
                     size_t end) {
  const ProjectVjpKernel kernel{gaussians, view, splats, d_splats, gradients};
  for (size_t i = begin; i < end; ++i) kernel(i);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(ProjectRange);
HWY_EXPORT(ProjectVjpRange);
}  // namespace math

namespace {
constexpr size_t kGrain = 512;
template <class F>
void ForRanges(size_t count, const F& f) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kGrain),
                    [&](const tbb::blocked_range<size_t>& r) { f(r.begin(), r.end()); });
}
}  // namespace

void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats) {
  using namespace math;
  ForRanges(gaussians.count, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(ProjectRange)(gaussians, view, splats, begin, end);
  });
}

void LaunchProjectVjp(const WorldGaussians& gaussians,
                      const ViewParameters& view,
                      const ProjectedSplat* splats,
                      const SplatGradient* d_splats,
                      const WorldGradients& gradients) {
  using namespace math;
  ForRanges(gaussians.count, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(ProjectVjpRange)(gaussians, view, splats, d_splats, gradients, begin, end);
  });
}

}  // namespace cosplat
#endif

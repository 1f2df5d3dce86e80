// The kernels of anti-aliased Gaussians, in a file of their own: the compiler rounds the others as
// before.
#include "splat/render/cpu/launch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/render/cpu/launch_antialiased.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/render/cpu/project_range.h"

COSPLAT_MATH_BEGIN

void ProjectAntialiasedRange(const WorldGaussians& gaussians,
                             const ViewParameters& view,
                             ProjectedSplat* splats,
                             float* radii,
                             size_t begin,
                             size_t end) {
  RunRange(ProjectKernel<true>{gaussians, view, splats, radii}, begin, end);
}

void ProjectAntialiasedVjpRange(const WorldGaussians& gaussians,
                                const ViewParameters& view,
                                const ProjectedSplat* splats,
                                const float* radii,
                                const SplatGradient* d_splats,
                                const WorldGradients& gradients,
                                size_t begin,
                                size_t end) {
  RunDrawnGroups(
      ProjectVjpKernel<true>{gaussians, view, splats, radii, d_splats, gradients}, begin, end);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(ProjectAntialiasedRange);
HWY_EXPORT(ProjectAntialiasedVjpRange);
}  // namespace math

void ProjectAntialiased(const WorldGaussians& gaussians,
                        const ViewParameters& view,
                        ProjectedSplat* splats,
                        float* radii,
                        size_t begin,
                        size_t end) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(ProjectAntialiasedRange)(gaussians, view, splats, radii, begin, end);
}

void ProjectAntialiasedVjp(const WorldGaussians& gaussians,
                           const ViewParameters& view,
                           const ProjectedSplat* splats,
                           const float* radii,
                           const SplatGradient* d_splats,
                           const WorldGradients& gradients,
                           size_t begin,
                           size_t end) {
  using namespace math;
  HWY_DYNAMIC_DISPATCH(ProjectAntialiasedVjpRange)
  (gaussians, view, splats, radii, d_splats, gradients, begin, end);
}

}  // namespace cosplat
#endif

#include "splat/render/cpu/launch.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "splat/base/error.h"
#include "splat/render/rasterizer.h"
#include "splat/render/view_splats.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/render/cpu/launch.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "splat/render/cpu/project_range.h"
#include "splat/render/kernels/view_splats.h"

COSPLAT_MATH_BEGIN

void ProjectRange(const WorldGaussians& gaussians,
                  const ViewParameters& view,
                  ProjectedSplat* splats,
                  float* radii,
                  size_t begin,
                  size_t end) {
  RunRange(ProjectKernel<false>{gaussians, view, splats, radii}, begin, end);
}

void ProjectVjpRange(const WorldGaussians& gaussians,
                     const ViewParameters& view,
                     const ProjectedSplat* splats,
                     const float* radii,
                     const SplatGradient* d_splats,
                     const WorldGradients& gradients,
                     size_t begin,
                     size_t end) {
  RunDrawnGroups(
      ProjectVjpKernel<false>{gaussians, view, splats, radii, d_splats, gradients}, begin, end);
}

void ViewSplatRange(const WorldGaussians& gaussians,
                    const ViewParameters& view,
                    float blur_variance,
                    ViewSplats& out,
                    size_t begin,
                    size_t end) {
  RunRange(ViewSplatKernel{gaussians,
                           view,
                           blur_variance,
                           out.unsorted[0].data(),
                           out.unsorted[1].data(),
                           out.unsorted[2].data(),
                           out.unsorted[3].data(),
                           out.depths.data()},
           begin,
           end);
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(ViewSplatRange);
HWY_EXPORT(ProjectRange);
HWY_EXPORT(ProjectVjpRange);
}  // namespace math

namespace {
// A multiple of kGaussianGroup, which is a multiple of every pack's lane count.
constexpr size_t kGrain = 512;
template <class F>
void ForRanges(size_t count, const F& f) {
  tbb::parallel_for(size_t(0), (count + kGrain - 1) / kGrain, [&](size_t chunk) {
    f(chunk * kGrain, std::min((chunk + 1) * kGrain, count));
  });
}
}  // namespace

void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats,
                   float* radii) {
  using namespace math;
  ForRanges(gaussians.count, [&](size_t begin, size_t end) {
    if (gaussians.antialiased)
      return ProjectAntialiased(gaussians, view, splats, radii, begin, end);
    HWY_DYNAMIC_DISPATCH(ProjectRange)(gaussians, view, splats, radii, begin, end);
  });
}

void LaunchProjectVjp(const WorldGaussians& gaussians,
                      const ViewParameters& view,
                      const ProjectedSplat* splats,
                      const float* radii,
                      const SplatGradient* d_splats,
                      const WorldGradients& gradients) {
  using namespace math;
  ForRanges(gaussians.count, [&](size_t begin, size_t end) {
    if (gaussians.antialiased)
      return ProjectAntialiasedVjp(gaussians, view, splats, radii, d_splats, gradients, begin, end);
    HWY_DYNAMIC_DISPATCH(ProjectVjpRange)
    (gaussians, view, splats, radii, d_splats, gradients, begin, end);
  });
}

void FillViewSplats(const WorldGaussians& gaussians,
                    Basis basis,
                    const Camera& camera,
                    int degree,
                    float blur_variance,
                    ViewSplats& out) {
  using namespace math;
  RenderSettings settings;
  settings.degree = degree;
  CheckArguments(gaussians, camera, settings);
  if (gaussians.antialiased)
    throw Error("splats", "are anti-aliased, which no other program's renderer draws");
  const ViewParameters view = ViewOfCamera(camera, basis, degree);
  Buffer<float>* const sorted[4] = {&out.centers, &out.colors, &out.scales, &out.rotations};
  for (int k = 0; k < 4; ++k) {
    out.unsorted[k].resize(4 * gaussians.count);
    sorted[k]->resize(4 * gaussians.count);
  }
  out.depths.resize(gaussians.count);
  out.order.Refill(gaussians.count, HostStream());
  ForRanges(gaussians.count, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(ViewSplatRange)
    (gaussians, view, blur_variance, out, begin, end);
    for (size_t i = begin; i < end; ++i) {
      out.order.keys[i] = BitsOf(out.depths[i]);
      out.order.values[i] = uint32_t(i);
    }
  });
  HostStream().Sort(out.order, 32);
  ForRanges(gaussians.count, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      for (int k = 0; k < 4; ++k)
        std::copy_n(out.unsorted[k].data() + 4 * out.order.values[i], 4, sorted[k]->data() + 4 * i);
  });
}

}  // namespace cosplat
#endif

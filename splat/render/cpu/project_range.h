// Runs the element-wise kernels of splat/render/kernels/project.h on packs of Gaussians; shared by
// launch.cpp and launch_antialiased.cpp, which compile one form of them each.
#if defined(COSPLAT_SPLAT_CPU_PROJECT_RANGE_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_CPU_PROJECT_RANGE_H_
#undef COSPLAT_SPLAT_CPU_PROJECT_RANGE_H_
#else
#define COSPLAT_SPLAT_CPU_PROJECT_RANGE_H_
#endif

#include <algorithm>

#include "splat/render/cpu/pack_rows.h"
#include "splat/render/kernels/project.h"

COSPLAT_MATH_BEGIN

// Runs a kernel on packs of consecutive rows.
template <class Kernel>
void RunRange(const Kernel& kernel, size_t begin, size_t end) {
  for (size_t i = begin; i < end; i += kLanes)
    kernel.template Run<Pack>(Rows{i, std::min(kLanes, end - i)});
}

// Runs a ProjectVjpKernel on the groups with a visible Gaussian.
template <class Kernel>
void RunDrawnGroups(const Kernel& kernel, size_t begin, size_t end) {
  for (size_t group = begin; group < end; group += kGaussianGroup) {
    const size_t group_end = std::min(group + kGaussianGroup, end);
    const bool drawn =
        std::any_of(kernel.radii + group, kernel.radii + group_end, [](float r) { return r > 0; });
    if (drawn)
      RunRange(kernel, group, group_end);
    else if (!kernel.out.drawn_groups_only)
      kernel.ZeroAll(Rows{group, group_end - group});
  }
}

COSPLAT_MATH_END
#endif

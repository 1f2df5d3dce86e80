// Adam over groups of Gaussians (splat/train/optimize/optimizer.h), element by element.
#pragma once

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/math/adam.h"
#include "splat/math/scalar.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/optimize/cpu/adam_runs.h"

namespace cosplat {

constexpr uint32_t kNotNow = 0xffffffffu;

// Whether a group has a Gaussian with a positive number, such as the radius of a visible one.
COSPLAT_HD bool AnyPositive(View<const float> of, size_t group) {
  const size_t end = math::Min((group + 1) * kGaussianGroup, of.count);
  for (size_t i = group * kGaussianGroup; i < end; ++i)
    if (of[i] > 0) return true;
  return false;
}

// Finds which groups a step updates and how many steps each of them is behind; one call per group.
struct FindBehind {
  View<const float> update_mask;  // [N] not positive: no gradient; empty: all groups are updated
  uint32_t before, after;         // step counts; equal: catch-up
  View<uint32_t> updated, behind;
  const uint32_t* overflowed;  // or null
  COSPLAT_HD void operator()(size_t g) const {
    const bool now = !(overflowed && *overflowed != 0) &&
                     (update_mask.count == 0 || AnyPositive(update_mask, g)) && updated[g] != after;
    behind[g] = now ? before - updated[g] : kNotNow;
    if (now) updated[g] = after;
  }
};

// Updates element i of every attribute that has that many. On the host, processes runs of groups;
// on a device, one element per thread (splat/train/cuda/kernels.cu).
struct UpdateNumbers {
  AdamArray attributes[kAttributeCount];
  View<const uint32_t> behind;  // [groups] steps to catch up, or kNotNow
  uint32_t* ignored;            // counts non-finite gradients
};
void RunOnHost(size_t n, const UpdateNumbers& kernel);

}  // namespace cosplat

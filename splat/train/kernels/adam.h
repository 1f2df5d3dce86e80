// Adam over groups of Gaussians (splat/train/optimizer.h), element by element.
#pragma once

#include "splat/device/buffer.h"
#include "splat/gaussians.h"
#include "splat/math/adam.h"
#include "splat/math/scalar.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/cpu/adam_runs.h"

namespace cosplat {

constexpr uint32_t kNotNow = 0xffffffffu;

// Which groups a step works on, and how late each is: a group each.
struct FindBehind {
  View<const float> moves;  // [N] not positive: no gradient; or empty: all groups
  uint32_t before, after;   // steps
  View<uint32_t> updated, behind;
  const uint32_t* overflowed;  // or null
  COSPLAT_HD void operator()(size_t g) const {
    const bool now = !(overflowed && *overflowed != 0) && (moves.count == 0 || AnyMoves(g));
    behind[g] = now ? before - updated[g] : kNotNow;
    if (now) updated[g] = after;
  }
  COSPLAT_HD bool AnyMoves(size_t g) const {
    const size_t end = math::Min((g + 1) * kGaussianGroup, moves.count);
    for (size_t i = g * kGaussianGroup; i < end; ++i)
      if (moves[i] > 0) return true;
    return false;
  }
};

// Number i of every attribute that has so many. On the host in runs of groups, on a device a number
// each (splat/train/cuda/kernels.cu).
struct UpdateNumbers {
  AdamArray attributes[kAttributeCount];
  View<const uint32_t> behind;  // [groups] steps to make up for, or kNotNow
  uint32_t* ignored;            // gradients that are not finite are counted
};
void RunOnHost(size_t n, const UpdateNumbers& kernel);

}  // namespace cosplat

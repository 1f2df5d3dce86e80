// Groups of Gaussians copied to messages between ranks and back, and views' gradients added up
// (splat/train/ranks/shards.h, splat/train/ranks/view_exchange.h, splat/train/step/gradient_sum.h).
//
// The kernels that process groups of kGaussianGroup do so whole on the host; on a device each of
// kGroupParts threads has a part of a group's numbers.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/device/for_each.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/optimize/kernels/adam.h"
#include "splat/train/ranks/row_share.h"
#include "splat/train/state/kernels/statistics.h"

namespace cosplat {

// Threads of a device for a group: their numbers lie next to each other.
constexpr size_t kGroupParts = 16;
constexpr size_t kGroupsPerBlock = kRowsPerBlock / kGaussianGroup;

// kernel(k) for k < n groups.
template <class Kernel>
void ForEachGroup(size_t n, Stream& stream, const Kernel& kernel) {
  if (!stream.on_host()) return KernelLaunch<Kernel>::Run(n, stream, kernel);
  ParallelFor(n, kernel, kGroupsPerBlock);
}

// The Gaussians of a group, of which the last may be smaller.
COSPLAT_HD size_t RowsOfGroup(size_t group, size_t gaussians) {
  const size_t rest = gaussians - group * kGaussianGroup;
  return rest < kGaussianGroup ? rest : kGaussianGroup;
}

struct FindDrawn {
  View<const float> radii;
  View<uint8_t> drawn;  // [groups]
  COSPLAT_HD void operator()(size_t g) const { drawn[g] = AnyPositive(radii, g) ? 1 : 0; }
};

// Copies groups; those that are smaller where they come from are filled up with zeros.
struct CopyGroup {
  GroupPlaces from, to;
  COSPLAT_HD void operator()(size_t k) const { Part<1>(k, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t k, size_t part) const {
    const size_t source = from.At(k), target = to.At(k);
    const size_t room = RowsOfGroup(target, to.rows);
    const size_t there = RowsOfGroup(source, from.rows), rows = there < room ? there : room;
    for (size_t a = 0; a < from.arrays.count; ++a) {
      const size_t width = from.arrays.array[a].width;
      const float* in = from.arrays.array[a].data + source * kGaussianGroup * width;
      float* out = to.arrays.array[a].data + target * kGaussianGroup * width;
      for (size_t n = part; n < rows * width; n += kParts) out[n] = in[n];
      for (size_t n = rows * width + part; n < room * width; n += kParts) out[n] = 0;
    }
  }
};

// Row k of `from` becomes row rows[k].
struct ScatterRow {
  const float* from;
  View<const uint32_t> rows;
  size_t width;
  View<float> to;
  COSPLAT_HD void operator()(size_t k) const {
    for (size_t n = 0; n < width; ++n) to[rows[k] * width + n] = from[k * width + n];
  }
};

// Makes the colour of Gaussians that have a coefficient which is not finite NaN: what stands for
// them where their coefficients are not.
struct SpoilBroken {
  View<const float> color_rest;
  size_t width;
  View<float> color_dc;  // [N, 3]
  COSPLAT_HD void operator()(size_t i) const {
    for (size_t n = 0; n < width; ++n)
      if (!std::isfinite(color_rest[i * width + n])) color_dc[3 * i] = NAN;
  }
};

// Adds what a view shows of a part of the Gaussians: group k of the part is group first + k of all.
struct AddGroup {
  RowArrays view, sums;  // the attributes
  View<const float> radii;
  size_t first, gaussians;
  View<const uint8_t> seen;  // [groups] whether `sums` is set
  float weight;
  View<float> update_mask;  // [N] set to 1 where visible
  bool gathers;
  AccumulateStep accumulate;  // into statistics, if it gathers them
  COSPLAT_HD void operator()(size_t k) const { Part<1>(k, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t k, size_t part) const {
    if (!AnyPositive(radii, k)) return;
    const size_t row = k * kGaussianGroup, at = (first + k) * kGaussianGroup;
    const size_t rows = RowsOfGroup(first + k, gaussians);
    for (size_t a = 0; a < view.count; ++a) {
      const size_t width = view.array[a].width;
      const float* in = view.array[a].data + row * width;
      float* sum = sums.array[a].data + at * width;
      if (seen[first + k])
        for (size_t n = part; n < rows * width; n += kParts) sum[n] += weight * in[n];
      else
        for (size_t n = part; n < rows * width; n += kParts) sum[n] = weight * in[n];
    }
    for (size_t i = part; i < rows; i += kParts) {
      if (radii[row + i] > 0) update_mask[at + i] = 1;
      if (gathers) accumulate.Add(at + i, row + i);
    }
  }
};

// Marks the groups that a view shows.
struct MarkSeen {
  View<const float> radii;
  size_t first;
  View<uint8_t> seen;  // [groups]
  COSPLAT_HD void operator()(size_t k) const {
    if (AnyPositive(radii, k)) seen[first + k] = 1;
  }
};

// Clears the sums of a group that no view shows.
struct ZeroUnseenGroup {
  RowArrays sums;
  size_t gaussians;
  View<const uint8_t> seen;
  COSPLAT_HD void operator()(size_t g) const { Part<1>(g, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t g, size_t part) const {
    if (seen[g]) return;
    const size_t first = g * kGaussianGroup, rows = RowsOfGroup(g, gaussians);
    for (size_t a = 0; a < sums.count; ++a) {
      const size_t width = sums.array[a].width;
      for (size_t n = part; n < rows * width; n += kParts)
        sums.array[a].data[first * width + n] = 0;
    }
  }
};

}  // namespace cosplat

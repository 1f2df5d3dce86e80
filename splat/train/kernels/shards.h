// What ranks send each other of many Gaussians, packed and unpacked, and views' gradients added up
// (splat/train/shards.h, splat/train/gradient_sum.h).
//
// The kernels that process groups of kGaussianGroup do so whole on the host; on a device each of
// kGroupParts threads has a part of a group's numbers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/device/for_each.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/kernels/adam.h"
#include "splat/train/kernels/step.h"
#include "splat/train/row_share.h"

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

// Group groups[k] becomes group k of a message, filled up with zeros.
struct PackGroup {
  RowArrays from, to;
  View<const uint32_t> groups;
  uint32_t* index;   // [groups.count] the message's copy of `groups`
  size_t gaussians;  // in `from`
  COSPLAT_HD void operator()(size_t k) const { Part<1>(k, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t k, size_t part) const {
    const size_t first = groups[k] * kGaussianGroup, rows = RowsOfGroup(groups[k], gaussians);
    if (part == 0) index[k] = groups[k];
    for (size_t a = 0; a < from.count; ++a) {
      const size_t width = from.array[a].width;
      const float* in = from.array[a].data + first * width;
      float* out = to.array[a].data + k * kGaussianGroup * width;
      for (size_t n = part; n < rows * width; n += kParts) out[n] = in[n];
      for (size_t n = rows * width + part; n < kGaussianGroup * width; n += kParts) out[n] = 0;
    }
  }
};

// The way back.
struct UnpackGroup {
  RowArrays from, to;
  View<const uint32_t> groups;
  size_t gaussians;  // in `to`
  COSPLAT_HD void operator()(size_t k) const { Part<1>(k, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t k, size_t part) const {
    const size_t first = groups[k] * kGaussianGroup, rows = RowsOfGroup(groups[k], gaussians);
    for (size_t a = 0; a < from.count; ++a) {
      const size_t width = from.array[a].width;
      const float* in = from.array[a].data + k * kGaussianGroup * width;
      float* out = to.array[a].data + first * width;
      for (size_t n = part; n < rows * width; n += kParts) out[n] = in[n];
    }
  }
};

// Sets values of the groups that a message has.
struct SetOfGroups {
  View<const uint32_t> groups;
  uint32_t value;
  View<uint32_t> of;  // [groups of all]
  COSPLAT_HD void operator()(size_t k) const { of[groups[k]] = value; }
};
struct MarkGroups {
  View<const uint32_t> groups;
  View<uint8_t> marks;  // [groups of all]
  COSPLAT_HD void operator()(size_t k) const { marks[groups[k]] = 1; }
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

// Where the sums of a rank's own Gaussians are.
struct OwnSums {
  RowShare share;
  RowArray sum[kAttributeCount];  // [own rows]
  size_t gaussians;               // of all ranks
  View<const uint8_t> seen;       // [groups] whether `sum` is set
};

// Adds a view's gradients of own groups[k].
struct AddGroup {
  OwnSums to;
  RowArrays view;  // attributes, gradient of the centre in the image, radius
  bool packed;     // row kGaussianGroup * k of `view` is the first of groups[k]; else of group k
  View<const uint32_t> groups;
  float weight;
  View<float> moves;  // [N] set to 1 where visible
  bool gathers;
  AccumulateStep accumulate;  // into statistics, if it gathers them
  COSPLAT_HD void operator()(size_t k) const { Part<1>(k, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t k, size_t part) const {
    const size_t g = groups[k], first = g * kGaussianGroup, place = to.share.PlaceOf(first);
    const size_t row = packed ? k * kGaussianGroup : first, rows = RowsOfGroup(g, to.gaussians);
    for (int a = 0; a < kAttributeCount; ++a) {
      const size_t width = view.array[a].width;
      const float* in = view.array[a].data + row * width;
      float* sum = to.sum[a].data + place * width;
      if (to.seen[g])
        for (size_t n = part; n < rows * width; n += kParts) sum[n] += weight * in[n];
      else
        for (size_t n = part; n < rows * width; n += kParts) sum[n] = weight * in[n];
    }
    for (size_t i = part; i < rows; i += kParts) {
      if (accumulate.radii[row + i] > 0) moves[first + i] = 1;
      if (gathers) accumulate.Add(first + i, row + i);
    }
  }
};

// Of group g, if it is an own one that no view shows.
struct ZeroUnseenGroup {
  OwnSums of;
  COSPLAT_HD void operator()(size_t g) const { Part<1>(g, 0); }
  template <size_t kParts>
  COSPLAT_HD void Part(size_t g, size_t part) const {
    if (of.seen[g] || !of.share.Owns(g * kGaussianGroup)) return;
    const size_t place = of.share.PlaceOf(g * kGaussianGroup), rows = RowsOfGroup(g, of.gaussians);
    for (const RowArray& sum : of.sum)
      for (size_t n = part; n < rows * sum.width; n += kParts) sum.data[place * sum.width + n] = 0;
  }
};

}  // namespace cosplat

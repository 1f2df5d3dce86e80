// The kernels of density control (splat/train/density/density.h): which Gaussians are cloned, split
// or removed, where each of them goes, and Morton order.
#pragma once

#include <cfloat>

#include "splat/device/sort.h"
#include "splat/math/morton.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/density/kernels/density.h"
#include "splat/train/state/kernels/statistics.h"

namespace cosplat {

// What density control does with a Gaussian.
enum DensityKind : uint8_t { kStays, kIsCloned, kIsSplit };

// Decides each Gaussian's kind and flags those that are cloned or split.
struct FindKinds {
  View<const float> screen_gradient, visible, scale_log;
  float threshold, split_scale;
  View<float> mean;
  View<uint8_t> kind;
  View<uint64_t> chosen;  // [N + 1]
  COSPLAT_HD void operator()(size_t i) const {
    chosen[i] = 0;
    if (i == mean.count) return;
    mean[i] = math::MeanWhereVisible(screen_gradient[i], visible[i]);
    kind[i] = kStays;
    if (!(mean[i] >= threshold)) return;
    chosen[i] = 1;
    kind[i] = math::LargestScale(&scale_log[3 * i]) > split_scale ? kIsSplit : kIsCloned;
  }
};

// Sort keys: strongest gradient first, then those that are not chosen. Means are not negative, so
// their bits order like values.
struct StrengthKey {
  View<const float> mean;
  View<const uint8_t> kind;
  View<uint32_t> keys, gaussians;
  COSPLAT_HD void operator()(size_t i) const {
    keys[i] = kind[i] == kStays ? 0xffffffffu : 0x7fffffffu - BitsOf(mean[i]);
    gaussians[i] = uint32_t(i);
  }
};

struct LetStay {
  View<const uint32_t> gaussians;
  size_t from;
  View<uint8_t> kind;
  COSPLAT_HD void operator()(size_t k) const { kind[gaussians[from + k]] = kStays; }
};

// Runs before the copies are made.
struct ShareOpacity {
  View<const uint8_t> kind;
  View<float> opacity_logit;
  COSPLAT_HD void operator()(size_t i) const {
    if (kind[i] == kIsCloned) opacity_logit[i] = math::SharedOpacityLogit(opacity_logit[i]);
  }
};

struct FlagKinds {
  View<const uint8_t> kind;
  View<uint64_t> kept, cloned, split;
  COSPLAT_HD void operator()(size_t i) const {
    const bool one = i < kind.count;
    kept[i] = one && kind[i] != kIsSplit;
    cloned[i] = one && kind[i] == kIsCloned;
    split[i] = one && kind[i] == kIsSplit;
  }
};

// Output order: the Gaussians that are kept, then clones, then two children of each that is split.
struct PlaceSources {
  View<const uint8_t> kind;
  View<const uint64_t> kept, cloned, split;
  size_t first_clone, first_child;
  View<uint32_t> source;
  COSPLAT_HD void operator()(size_t i) const {
    const uint32_t me = uint32_t(i);
    if (kind[i] != kIsSplit) source[kept[i]] = me;
    if (kind[i] == kIsCloned) source[first_clone + cloned[i]] = me;
    if (kind[i] == kIsSplit)
      for (int k = 0; k < 2; ++k) source[first_child + 2 * split[i] + k] = me;
  }
};

// Draws each child's offset from its parent's position, where it starts, and shrinks its scale.
struct DrawChild {
  size_t first;
  Rng rng;  // before the first child
  float shrink_log;
  View<const float> rotation;
  View<float> offsets, scale_log;
  COSPLAT_HD void operator()(size_t c) const {
    const size_t i = first + c;
    Rng mine = rng.After(c * math::kSplitDraws);
    const math::Vec3<float> offset = math::SplitOffset(&rotation[4 * i], &scale_log[3 * i], mine);
    offsets[3 * c] = offset.x;
    offsets[3 * c + 1] = offset.y;
    offsets[3 * c + 2] = offset.z;
    for (int k = 0; k < 3; ++k) scale_log[3 * i + k] -= shrink_log;
  }
};

// Two children of each that is split, one after the other.
struct CutChild {
  size_t first;
  View<const float> rotation;
  View<float> offsets, scale_log, opacity_logit;
  COSPLAT_HD void operator()(size_t c) const {
    const size_t i = first + c;
    const math::Vec3<float> offset =
        math::HalfOffset(&rotation[4 * i], &scale_log[3 * i], c % 2 == 0 ? 1.0f : -1.0f);
    offsets[3 * c] = offset.x;
    offsets[3 * c + 1] = offset.y;
    offsets[3 * c + 2] = offset.z;
    math::CutInHalf(&scale_log[3 * i], opacity_logit[i]);
  }
};

struct MarkUnwanted {
  math::RemovalRule rule;
  WorldGaussians gaussians;
  View<uint8_t> unwanted;
  COSPLAT_HD static bool AllFinite(const float* row, int width) {
    for (int k = 0; k < width; ++k)
      if (!std::isfinite(row[k])) return false;
    return true;
  }
  COSPLAT_HD void operator()(size_t i) const {
    const WorldGaussians& g = gaussians;
    const bool whole = AllFinite(g.position + 3 * i, 3) && AllFinite(g.rotation + 4 * i, 4) &&
                       AllFinite(g.scale_log + 3 * i, 3) && AllFinite(g.opacity_logit + i, 1) &&
                       AllFinite(g.color_dc + 3 * i, 3) &&
                       AllFinite(g.color_rest + g.rest_width * i, g.rest_width);
    unwanted[i] =
        !whole || RemovalOf(rule, g.opacity_logit[i], g.scale_log + 3 * i) != math::Removal::kNone;
  }
};

struct FlagKept {
  View<const uint8_t> unwanted;
  View<uint64_t> kept;
  COSPLAT_HD void operator()(size_t i) const { kept[i] = i < unwanted.count && !unwanted[i]; }
};

struct PlaceKept {
  View<const uint8_t> unwanted;
  View<const uint64_t> kept;
  View<uint32_t> source;
  COSPLAT_HD void operator()(size_t i) const {
    if (!unwanted[i]) source[kept[i]] = uint32_t(i);
  }
};

struct LowerTo {
  View<float> numbers;
  float limit;
  COSPLAT_HD void operator()(size_t i) const {
    if (limit < numbers[i]) numbers[i] = limit;
  }
};

struct FillNumbers {
  View<uint32_t> numbers;
  uint32_t value;
  COSPLAT_HD void operator()(size_t i) const { numbers[i] = value; }
};

// Bounding box of each block of points: lowest and highest corner; non-finite points are ignored.
struct FindBoxes {
  static constexpr size_t kBlock = 256;
  View<const float> points;  // [n, 3]
  View<float> boxes;         // [blocks, 6]
  COSPLAT_HD void operator()(size_t b) const {
    float* box = &boxes[6 * b];
    for (int k = 0; k < 3; ++k) box[k] = FLT_MAX, box[3 + k] = -FLT_MAX;
    const size_t n = points.count / 3;
    for (size_t i = b * kBlock; i < (b + 1) * kBlock && i < n; ++i) {
      const float* p = &points[3 * i];
      if (!math::IsFinitePoint(p)) continue;
      for (int k = 0; k < 3; ++k) {
        box[k] = math::Min(box[k], p[k]);
        box[3 + k] = math::Max(box[3 + k], p[k]);
      }
    }
  }
};
// Joins all boxes into the first, in a single call.
struct JoinBoxes {
  View<float> boxes;
  COSPLAT_HD void operator()(size_t) const {
    for (size_t b = 6; b < boxes.count; b += 6)
      for (int k = 0; k < 3; ++k) {
        boxes[k] = math::Min(boxes[k], boxes[b + k]);
        boxes[3 + k] = math::Max(boxes[3 + k], boxes[b + 3 + k]);
      }
  }
};

// Keys of two stable sorts: by the lower half of the codes first, then by the upper half.
struct LowKeys {
  View<const float> position, box;
  View<uint64_t> codes;
  View<uint32_t> keys, gaussians;
  COSPLAT_HD void operator()(size_t i) const {
    codes[i] = math::MortonCode(&position[3 * i], &box[0], &box[3]);
    keys[i] = uint32_t(codes[i]);
    gaussians[i] = uint32_t(i);
  }
};
struct HighKeys {
  View<const uint64_t> codes;
  View<const uint32_t> gaussians;
  View<uint32_t> keys;
  COSPLAT_HD void operator()(size_t k) const { keys[k] = uint32_t(codes[gaussians[k]] >> 32); }
};

}  // namespace cosplat

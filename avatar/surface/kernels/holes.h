// Detection of holes that pruning would open in an avatar, for the CPU and for a device: the pixels
// that lose their cover, and the Gaussians near them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "avatar/surface/kernels/arrays.h"
#include "splat/device/buffer.h"
#include "splat/render/kernels/project.h"

namespace cosplat::math {

// A triangle's last Gaussian is removed only while the alpha inside the silhouette stays above
// this.
constexpr float kHoleAlpha = 0.9f;
// The smallest loss of alpha that counts: one grey level.
constexpr float kAlphaLoss = 1.0f / 255;

// Number of training frames, evenly spaced, that are searched for holes; index of the k-th.
constexpr size_t kHoleFrames = 3;
COSPLAT_HD size_t HoleFrame(size_t k, size_t frame_count) { return k * frame_count / kHoleFrames; }

// before, after: the pixel's transmittance with all Gaussians, and without those to be removed. A
// pixel that was already uncovered (after an opacity reset) counts too: its alpha must not fall
// further.
COSPLAT_HD bool IsHole(bool inside_silhouette, float before, float after) {
  return inside_silhouette && 1 - after < kHoleAlpha && after - before > kAlphaLoss;
}

// Opacity logit that makes a Gaussian invisible.
constexpr float kGoneLogit = -100;

struct HoleMask {
  const uint8_t* holes;  // [height, width] 1: a hole
  int width, height;

  // Whether the centre of a hole pixel is within `radius` of (x, y); px.
  COSPLAT_HD bool HasWithin(float x, float y, float radius) const {
    const int x0 = PixelAt(x - radius, width), x1 = PixelAt(x + radius + 1, width);
    const int y0 = PixelAt(y - radius, height), y1 = PixelAt(y + radius + 1, height);
    for (int j = y0; j < y1; ++j)
      for (int i = x0; i < x1; ++i) {
        const float dx = i + 0.5f - x, dy = j + 0.5f - y;
        if (holes[size_t(j) * size_t(width) + size_t(i)] && std::sqrt(dx * dx + dy * dy) <= radius)
          return true;
      }
    return false;
  }

 private:
  COSPLAT_HD static int PixelAt(float at, int count) {
    return at > 0 ? at < float(count) ? int(at) : count : 0;
  }
};

}  // namespace cosplat::math

namespace cosplat {

// The steps of HoleGuard (avatar/train/hole_guard.h).

// One face per index: marks its Gaussians if all of them are to be removed.
struct FindLast {
  FaceListArrays lists;
  View<const uint8_t> unwanted;
  View<uint8_t> last;
  View<uint64_t> any;  // [F + 1]
  COSPLAT_HD void operator()(size_t f) const {
    any[f] = 0;
    if (f + 1 == any.count) return;
    const uint32_t begin = lists.begin[f], end = lists.begin[f + 1];
    bool none_left = true;
    for (uint32_t k = begin; k < end; ++k)
      if (!unwanted[lists.index[k]]) none_left = false;
    for (uint32_t k = begin; k < end; ++k) last[lists.index[k]] = none_left;
    any[f] = none_left && begin != end;
  }
};

// One Gaussian per index: makes those to be removed invisible.
struct ThinOut {
  View<const float> logits;
  View<const uint8_t> unwanted;
  View<float> thinned;
  COSPLAT_HD void operator()(size_t i) const {
    thinned[i] = unwanted[i] ? math::kGoneLogit : logits[i];
  }
};

// One pixel per index.
struct FindHoles {
  View<const uint8_t> silhouette;
  View<const float> before, after;
  View<uint8_t> holes;
  COSPLAT_HD void operator()(size_t p) const {
    holes[p] = math::IsHole(silhouette[p] != 0, before[p], after[p]);
  }
};

// One Gaussian per index: it is kept if it is rendered near a hole.
struct SpareOne {
  math::HoleMask mask;
  ViewParameters view;
  const float* position;  // [N, 3] world
  View<const uint8_t> last;
  View<const float> radii;
  View<uint8_t> unwanted;
  COSPLAT_HD void operator()(size_t i) const {
    if (!last[i] || !unwanted[i] || !(radii[i] > 0)) return;
    const math::Pinhole<float> pinhole = math::ToPinhole<float>(view);
    const float* p = position + 3 * i;
    const math::Vec2<float> center =
        math::ProjectPoint(pinhole, math::ToCamera(pinhole, {p[0], p[1], p[2]}));
    if (mask.HasWithin(center.x, center.y, radii[i])) unwanted[i] = 0;
  }
};

}  // namespace cosplat

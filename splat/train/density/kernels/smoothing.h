// The 3D smoothing filter of anti-aliased training (Yu et al. 2024, Mip-Splatting): no Gaussian is
// finer than the densest sampling of any training view can tell.
#pragma once

#include "splat/device/buffer.h"
#include "splat/math/pinhole.h"

namespace cosplat {

// One call per Gaussian. Where no view sees it, the view with the nearest centre counts, by its
// distance.
struct FindSmoothing {
  View<const math::Pinhole<float>> views;
  View<const float> position;  // [N, 3] world
  View<float> variance;        // [N] world units^2
  COSPLAT_HD void operator()(size_t i) const {
    const math::Vec3<float> p{position[3 * i], position[3 * i + 1], position[3 * i + 2]};
    float seen = 0, nearest = 0;
    for (size_t k = 0; k < views.count; ++k) {
      const math::Pinhole<float>& view = views[k];
      const math::Vec3<float> in_cam = math::ToCamera(view, p);
      seen = math::Max(seen, math::SamplingRate(view, in_cam));
      const float distance = math::Max(math::Sqrt(math::Dot(in_cam, in_cam)), view.near_plane);
      nearest = math::Max(nearest, math::Max(view.fx, view.fy) / distance);
    }
    const float rate = seen > 0 ? seen : nearest;
    variance[i] = kSmoothingVariance / (rate * rate);
  }
};

}  // namespace cosplat

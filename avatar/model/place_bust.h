// Moves the bust's vertices to where the bust is in a frame, in a stream's memory.
#pragma once

#include "avatar/math/bust.h"
#include "splat/device/buffer.h"

namespace cosplat {

// One vertex per index. At the mean place, nothing is rounded.
struct PlaceBust {
  View<const float> mean;  // [K, 3] metres, vertices at the bust's mean place
  math::Vec3<float> pivot;
  const math::BustMotion<float>* pose;
  float* out;  // [K, 3]
  COSPLAT_HD void operator()(size_t i) const {
    math::Vec3<float> p{mean[3 * i], mean[3 * i + 1], mean[3 * i + 2]};
    const bool moves = pose->turn.w != 1 || math::Dot(pose->shift, pose->shift) != 0;
    if (moves) p = math::MoveWithBust(*pose, pivot, p);
    out[3 * i] = p.x;
    out[3 * i + 1] = p.y;
    out[3 * i + 2] = p.z;
  }
};

}  // namespace cosplat

// Moves of Gaussians that are points in the world.
#pragma once

#include "splat/device/buffer.h"

namespace cosplat {

struct AddOffsets {
  View<const float> offsets;
  size_t first;
  View<float> position;
  COSPLAT_HD void operator()(size_t k) const { position[3 * first + k] += offsets[k]; }
};

}  // namespace cosplat

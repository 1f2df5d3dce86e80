// How far pixels are from a region of an image.
#pragma once

#include <cstdint>

#include "splat/base/image.h"

namespace cosplat {

// How far each pixel is outside the region where `mask` (1 channel) is at least `threshold`, px;
// negative inside. Measured to the nearest pixel's centre on the other side, less a half; infinite
// where all pixels are on one side.
Image SignedDistance(const Image8& mask, uint8_t threshold);

}  // namespace cosplat

// A block of a scene between what the blocks in front of it and behind it show in a view
// (splat/train/blocks/layers.h). Layers are bytes, [pixels, 4]: colours multiplied by alpha, alpha.
#pragma once

#include "splat/device/buffer.h"
#include "splat/math/photometric.h"

namespace cosplat {

// A layer over a colour, in one channel of one pixel; null: no layer.
COSPLAT_HD float LayerOver(const uint8_t* layer, size_t i, int channel, float color) {
  if (!layer) return color;
  const uint8_t* p = layer + 4 * i;
  return math::FromByte(p[channel]) + (1 - math::FromByte(p[3])) * color;
}

// One call per pixel: what was rendered over black gets the layer over the background behind it.
struct PutBehind {
  const uint8_t* layer;  // null: only the background
  float background[3];
  View<const float> transmittance;  // [pixels]
  View<float> color;                // [3, pixels]
  COSPLAT_HD void operator()(size_t i) const {
    for (int c = 0; c < 3; ++c)
      color[size_t(c) * transmittance.count + i] +=
          transmittance[i] * LayerOver(layer, i, c, background[c]);
  }
};

// One call per pixel.
struct PutInFront {
  const uint8_t* layer;     // null: none
  View<const float> color;  // [3, pixels]
  View<float> shown;        // [3, pixels]
  COSPLAT_HD void operator()(size_t i) const {
    const size_t plane = color.count / 3;
    for (int c = 0; c < 3; ++c) {
      const size_t at = size_t(c) * plane + i;
      shown[at] = LayerOver(layer, i, c, color[at]);
    }
  }
};

// Its derivative, in place.
struct PutInFrontVjp {
  const uint8_t* layer;  // not null
  View<float> d;         // [3, pixels]
  COSPLAT_HD void operator()(size_t i) const {
    const size_t plane = d.count / 3;
    const float share = 1 - math::FromByte(layer[4 * i + 3]);
    for (int c = 0; c < 3; ++c) d[size_t(c) * plane + i] *= share;
  }
};

}  // namespace cosplat

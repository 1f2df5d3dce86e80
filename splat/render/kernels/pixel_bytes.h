// The renderer's planes as RGBA bytes, a pixel at a time, for hosts and for devices.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/math/scalar.h"

namespace cosplat {

// What the fourth byte of a pixel says.
enum class AlphaMode {
  kStraight,       // colour not multiplied by alpha; of an image over black
  kPremultiplied,  // colour <= alpha; of an image over black
  kOpaque          // alpha 255, the colour as it is; of an image over its background
};

// As textures and image files have them.
struct alignas(4) PixelBytes {
  uint8_t red, green, blue, alpha;
};

// RenderedImage (splat/render/rasterizer.h), borrowed.
struct ImagePlanes {
  const float* color = nullptr;          // [3, pixels]
  const float* transmittance = nullptr;  // [pixels]
  size_t pixels = 0;
};

namespace math {

// [0, 1] to [0, 255], rounded; what is not a number is 0.
COSPLAT_HD uint8_t ToByte(float x) {
  return x > 0 ? uint8_t(Min(1.0f, x) * 255 + 0.5f) : uint8_t(0);
}

// color: over black where kMode is not kOpaque.
template <AlphaMode kMode>
COSPLAT_HD uint8_t ColorByte(float color, float alpha) {
  if (kMode == AlphaMode::kStraight) return ToByte(alpha > 0 ? color / alpha : 0.0f);
  if (kMode == AlphaMode::kPremultiplied) return ToByte(Min(alpha, color));
  return ToByte(color);
}

template <AlphaMode kMode>
COSPLAT_HD PixelBytes PixelAt(const ImagePlanes& planes, size_t p) {
  const float alpha = 1 - planes.transmittance[p];
  return {ColorByte<kMode>(planes.color[p], alpha),
          ColorByte<kMode>(planes.color[planes.pixels + p], alpha),
          ColorByte<kMode>(planes.color[2 * planes.pixels + p], alpha),
          kMode == AlphaMode::kOpaque ? uint8_t(255) : ToByte(alpha)};
}

}  // namespace math

template <AlphaMode kMode>
struct WritePixel {
  ImagePlanes planes;
  PixelBytes* pixels;
  COSPLAT_HD void operator()(size_t p) const { pixels[p] = math::PixelAt<kMode>(planes, p); }
};

}  // namespace cosplat

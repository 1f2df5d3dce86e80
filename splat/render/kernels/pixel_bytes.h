// Converts the renderer's planes to RGBA bytes, pixel by pixel, on the host or on a device.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/math/scalar.h"

namespace cosplat {

// Meaning of the alpha byte.
enum class AlphaMode {
  kStraight,       // colour not multiplied by alpha; needs an image over black
  kPremultiplied,  // colour <= alpha; needs an image over black
  kOpaque          // alpha is 255, colour unchanged; an image over its background
};

// As stored in textures and image files.
struct alignas(4) PixelBytes {
  uint8_t red, green, blue, alpha;
};

// Non-owning view of a RenderedImage (splat/render/rasterizer.h).
struct ImagePlanes {
  const float* color = nullptr;          // [3, pixels]
  const float* transmittance = nullptr;  // [pixels]
  size_t pixels = 0;
};

namespace math {

// Converts [0, 1] to [0, 255], clamped and rounded; NaN becomes 0.
COSPLAT_HD uint8_t ToByte(float x) {
  return x > 0 ? uint8_t(Min(1.0f, x) * 255 + 0.5f) : uint8_t(0);
}

// color: over black unless kMode is kOpaque.
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

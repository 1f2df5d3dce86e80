// Conversion of rendered images to four bytes per pixel, in memory of any layout.
//
// RenderedImage -> WriteImageBytes, WriteDepth -> the caller's rows.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/render/kernels/pixel_bytes.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

struct PixelLayout {
  AlphaMode alpha = AlphaMode::kStraight;
  bool blue_first = false;  // BGRA, not RGBA
};

// Row y begins at pixels + y * stride (in bytes, of either sign). Values are clamped to [0, 1] and
// rounded; NaN becomes 0.
void WriteImageBytes(const RenderedImage& image,
                     PixelLayout layout,
                     uint8_t* pixels,
                     ptrdiff_t stride);

// Writes the depth of an image over black whose colour is depth: the mean over the Gaussians seen
// in each pixel, infinity where nothing is seen. stride: bytes, a multiple of 4.
void WriteDepth(const RenderedImage& image, float* depth, ptrdiff_t stride);

}  // namespace cosplat

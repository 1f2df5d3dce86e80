// The renderer's planes as the pixels that hosts take: four bytes each, in memory of any layout.
//
// RenderedImage -> WriteImageBytes, WriteDepth -> rows of the caller's.
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

// Row y begins at pixels + y * stride (bytes, of either sign). Values are clamped to [0, 1] and
// rounded, what is not a number is 0.
void WriteImageBytes(const RenderedImage& image,
                     PixelLayout layout,
                     uint8_t* pixels,
                     ptrdiff_t stride);

// Of an image over black whose colour is depth: the mean over what is seen in each pixel, infinity
// where that is nothing. stride: bytes, a multiple of 4.
void WriteDepth(const RenderedImage& image, float* depth, ptrdiff_t stride);

}  // namespace cosplat

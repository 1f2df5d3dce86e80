// Half-resolution preview: renders a quarter of the pixels and enlarges the image to full size.
//
// Camera -> HalfResolution -> rasteriser -> EnlargeTwice -> image. For interactive viewing when the
// full image is too slow; the loss of quality is measured in docs/performance.md.
#pragma once

#include "splat/base/camera.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// The same view with pixels twice as wide and high: sides are rounded up and intrinsics exactly
// halved, so that pixel (x, y) covers pixels 2x, 2x + 1 by 2y, 2y + 1 of `camera`. If a side is
// odd, the last column or row reaches half a pixel beyond it.
Camera HalfResolution(const Camera& camera);

// Enlarges colour and transmittance of `half`, rendered with HalfResolution of a camera of `width`
// x `height` pixels, to that size: bilinear between pixel centres, repeating the outermost pixels
// beyond them. A constant image is preserved exactly. Bit-identical for any number of threads.
void EnlargeTwice(const RenderedImage& half, int width, int height, RenderedImage& out);

}  // namespace cosplat

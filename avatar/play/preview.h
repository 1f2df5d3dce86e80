// Half-resolution preview: a quarter of the pixels drawn, the image enlarged to the asked size.
//
// Camera -> HalfResolution -> rasteriser -> EnlargeTwice -> image. For looking around while
// something faster than the image is wanted; what it costs is in docs/decisions.md.
#pragma once

#include "splat/base/camera.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// The same view with pixels twice as wide and high: sides rounded up, intrinsics exactly halved, so
// that pixel (x, y) covers pixels 2x, 2x + 1 by 2y, 2y + 1 of `camera`. The last column and row of
// an odd side reach half a pixel beyond it.
Camera HalfResolution(const Camera& camera);

// Colour and transmittance of `half`, drawn through HalfResolution of a camera with `width` x
// `height` pixels, at that size: bilinear between the centres of its pixels, the outermost repeated
// beyond them. A flat image stays exactly as it is. Same bits for any number of threads.
void EnlargeTwice(const RenderedImage& half, int width, int height, RenderedImage& out);

}  // namespace cosplat

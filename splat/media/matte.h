// What a mask's file means. People's masks are 0 and 255, 0 and 1, labels, colours, or the alpha
// channel of a cut-out image; all of them become one channel of coverage.
#pragma once

#include "splat/base/image.h"

namespace cosplat {

// Whether an image's alpha says anything: it has four channels, not all of them opaque.
bool SaysAlpha(const Image8& image);

// RGB of an RGB or RGBA image.
Image8 RgbOf(const Image8& image);

// One channel, 0 to 255: of an alpha that is not opaque everywhere, else of the colours. By the
// first of these that holds:
//   labels (none above 31, as 0 and 1; or at most 64 colours): all but black is 255;
//   two values, of which one is 0: the other is 255;
//   else the brightest channel, so that soft edges stay soft.
Image8 MatteOf(const Image8& mask);

}  // namespace cosplat

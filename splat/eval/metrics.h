// How close a rendered image is to its image.
#pragma once

#include <string>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;  // px
};

struct ImageMetrics {
  double psnr = 0;         // dB over all pixels and channels, values in [0, 1]
  double ssim = 0;         // 11 x 11 Gaussian window, zero beyond the border (3DGS)
  double psnr_mask = 0;    // dB, squared differences weighted by the mask; 0 without one
  double psnr_region = 0;  // dB inside a rectangle; 0 without one
  // dB over the brightest fiftieth (of the truth) of what the mask shows wholly; 0 without a mask.
  double psnr_highlight = 0;
};

// Both RGB and of the same size. `mask`: one channel of that size, or null. Throws Error when sizes
// disagree.
ImageMetrics CompareImages(const Image8& rendered,
                           const Image8& truth,
                           const Image8* mask = nullptr,
                           const Rectangle* region = nullptr);

}  // namespace cosplat

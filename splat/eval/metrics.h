// Image quality of a rendering against its ground truth.
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
  // dB over the brightest fiftieth (by ground truth) of the pixels fully in the mask; 0 without it.
  double psnr_highlight = 0;
};

// dB, squared differences weighted by the mask. All three of equal size; RGB, RGB, one channel.
double MaskedPsnr(const Image8& rendered, const Image8& truth, const Image8& mask);

// Both images must be RGB and of equal size. `mask`: one channel of that size, or null. Throws
// Error if sizes differ.
ImageMetrics CompareImages(const Image8& rendered,
                           const Image8& truth,
                           const Image8* mask = nullptr,
                           const Rectangle* region = nullptr);

}  // namespace cosplat

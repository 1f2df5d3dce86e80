// The photometric loss over a band of rows of one channel: the vectorised inner part of
// splat/train/loss/loss.cpp. A single pass reads the rendered image and the bytes of the target
// image and writes the gradient; intermediate rows for the window are kept for fifteen rows, not
// for the whole image.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

struct SsimBand {
  int width = 0, height = 0;        // px, of the image
  int row_begin = 0, row_end = 0;   // the band
  const float* x = nullptr;         // a rendered channel [height, width]
  const uint8_t* target = nullptr;  // [height, width, target_channels], offset to the channel
  const uint8_t* alpha = nullptr;   // likewise, offset to alpha; null without alpha
  int target_channels = 0;          // 1, 3 or 4
  float background = 0;             // behind pixels with alpha below 255
};

// Weights of one value's terms in the loss: l1 |x - y| + mse (x - y)^2 - dssim SSIM.
struct ValueWeights {
  float l1 = 0, mse = 0, dssim = 0;
};

// Sums over a band of l1 |x - y| + mse (x - y)^2, and of SSIM if its weight is not zero.
struct LossSums {
  double pointwise = 0, ssim = 0;
};

// Number of floats of scratch, 64-byte aligned, that the functions below need.
size_t SsimScratch(int width);

// Writes the gradient of the sum over the whole image to the band's rows of d_x [height, width].
LossSums EvaluateBand(const SsimBand& band,
                      const ValueWeights& weights,
                      float* scratch,
                      float* d_x);

// The band's part of the sum of SSIM.
double SsimOfBand(const SsimBand& band, float* scratch);

}  // namespace cosplat

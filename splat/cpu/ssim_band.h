// Windowed SSIM over a band of rows of one channel: the vectorised inner part of splat/loss.cpp.
#pragma once

#include <cstddef>

namespace cosplat {

// One channel's planes, [height, width], and the rows [row_begin, row_end) to work on.
struct SsimBand {
  int width = 0, height = 0;
  int row_begin = 0, row_end = 0;
  const float* x = nullptr;
  const float* y = nullptr;
  float* partial_x = nullptr;  // dSSIM/d(window mean of x) at each pixel; null: not wanted
  float* partial_xx = nullptr;
  float* partial_xy = nullptr;
};

// Floats of scratch that either function needs.
size_t SsimScratch(int width, int rows);

// Returns the sum of SSIM over the band; writes the partials when they are given.
double SsimForward(const SsimBand& band, float* scratch);

// Adds factor * d(sum of SSIM over the image)/dx to d_x [height, width], over the band's rows.
void SsimBackward(const SsimBand& band, float factor, float* scratch, float* d_x);

}  // namespace cosplat

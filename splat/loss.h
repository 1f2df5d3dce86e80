// Photometric loss between a rendered image and its target, with its gradient.
//   value = l1 * mean|x - y| + dssim * (1 - SSIM(x, y)) + mse * mean (x - y)^2
// 3DGS: 0.8, 0.2, 0 (Kerbl et al. 2023, eq. 7). SplattingAvatar: 1, 0, 10.
#pragma once

#include <array>

#include "splat/base/image.h"
#include "splat/buffer.h"

namespace cosplat {

struct LossWeights {
  float l1 = 0.8f;
  float dssim = 0.2f;
  float mse = 0.0f;
};

// RGB or straight-alpha RGBA bytes over a background -> planar [3, height, width] in [0, 1].
void CompositeTarget(const Image8& image,
                     const std::array<float, 3>& background,
                     Buffer<float>& planar);

class PhotometricLoss {
 public:
  // rendered, target: [3, height, width]. Writes d_rendered (same shape). Returns the loss.
  double Evaluate(const LossWeights& weights,
                  int width,
                  int height,
                  View<const float> rendered,
                  View<const float> target,
                  Buffer<float>& d_rendered);

 private:
  Buffer<float> partial_x_, partial_xx_, partial_xy_;  // dSSIM/d(moments) [3, height, width]
};

// Mean SSIM over pixels and channels of planar [3, height, width] images.
double MeanSsim(int width, int height, View<const float> a, View<const float> b);

// 10 log10(1 / mean squared difference); 100 for equal images. Same shapes.
double Psnr(View<const float> a, View<const float> b);

}  // namespace cosplat

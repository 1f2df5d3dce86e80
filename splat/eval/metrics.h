// Image quality of a rendering against its ground truth.
#pragma once

#include <array>
#include <optional>

#include "splat/base/image.h"

namespace cosplat {

struct ImageMetrics {
  double psnr = 0;  // dB over all pixels and channels, values in [0, 1]
  double ssim = 0;  // 11 x 11 Gaussian window, zero beyond the border (3DGS)
  // None where there is no pixel to compare: a mask of zeros.
  std::optional<double> psnr_mask;  // dB, squared differences weighted by the mask
  // dB over the brightest fiftieth (by ground truth) of the pixels fully in the mask.
  std::optional<double> psnr_highlight;
};

// Whether a rendering can be measured against this picture. One that is all of one colour, such as
// the background under an empty mask, agrees with any rendering that shows nothing: 44 dB were
// printed of empty avatars.
bool HasContent(const Image8& truth);

// dB, squared differences weighted by the mask; none if that is zero everywhere. All three of equal
// size; RGB, RGB, one channel.
std::optional<double> MaskedPsnr(const Image8& rendered, const Image8& truth, const Image8& mask);
// The mask without what is outside of the box, which may go beyond it.
Image8 Inside(Image8 mask, const Crop& box);

// The image over the background, as 8-bit images are compared. Grey, RGB or straight-alpha RGBA.
Image8 OverBackground(const Image8& image, const std::array<float, 3>& background);

// Both images must be RGB and of equal size. `mask`: one channel of that size, or null. Throws
// Error if sizes differ.
ImageMetrics CompareImages(const Image8& rendered,
                           const Image8& truth,
                           const Image8* mask = nullptr);

}  // namespace cosplat

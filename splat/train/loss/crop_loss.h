// A loss of a random part of the image, added to the photometric loss (splat/train/loss/loss.h):
//   value = weight * distance(rendered crop, target crop)
// The distance is measured on the host; LPIPS (splat/eval/lpips.h) is one. Crops, because a
// network's time and memory grow with the pixels, and the mean over random crops stands for the
// loss of the image.
#pragma once

#include <memory>
#include <vector>

#include "splat/base/image.h"
#include "splat/base/rng.h"
#include "splat/device/buffer.h"

namespace cosplat {

class ImageDistance {
 public:
  virtual ~ImageDistance() = default;
  // Minimum width and height of the images, px.
  virtual int min_side() const = 0;
  // Compares planes [3, height, width] in [0, 1] (a rendering may exceed 1); d_rendered has their
  // shape.
  // Bit-identical for any number of threads. Throws Error if either is not finite.
  virtual double Evaluate(View<const float> rendered,
                          View<const float> target,
                          int width,
                          int height,
                          std::vector<float>& d_rendered) = 0;
};

struct CropLossSettings {
  float weight = 0;  // 0: off
  int side = 128;    // px, of the crop; at most the image's
  std::shared_ptr<ImageDistance> distance;
};

// At a place drawn so that it shows as much as possible of what is not transparent in the image.
// The same number of draws for any image.
Crop DrawCrop(const Image8& image, int side, Rng& rng);

}  // namespace cosplat

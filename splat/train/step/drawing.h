// What drawing a view and its backward pass leave, in the stream's memory; reused between steps.
#pragma once

#include <memory>

#include "splat/render/rasterizer.h"

namespace cosplat {

struct Drawing {
  WorldGaussians world;
  RenderedImage image;
  std::unique_ptr<RenderTape> tape;
  Gaussians gradients;   // of several views, of a part of the Gaussians at a time
  Buffer<float> screen;  // [N, 2] gradients of the centres
};

}  // namespace cosplat

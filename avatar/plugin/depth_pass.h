// Depth images.
//
// PosedGaussians + Camera -> DepthPass -> image of depths -> WriteDepth
// (avatar/play/image_bytes.h). The Gaussians are rendered a second time by the same renderer, with
// their depths as colours: each pixel then has the mean of the depths, with the weights of its
// colour.
#pragma once

#include <memory>

#include "avatar/play/player.h"
#include "splat/render/rasterizer.h"

namespace cosplat::plugin {

class DepthPass {
 public:
  DepthPass();
  // posed: by a player of `avatar`. The returned image, over black, is valid until the next call.
  const RenderedImage& Draw(const AvatarModel& avatar,
                            const PosedGaussians& posed,
                            const Camera& camera);

 private:
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  Buffer<float> color_dc_;  // [N, 3] coefficients whose colour is the depth
  RenderedImage image_;
};

}  // namespace cosplat::plugin

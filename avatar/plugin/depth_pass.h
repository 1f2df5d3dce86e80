// How far away what a picture shows is.
//
// PosedGaussians + Camera -> DepthPass -> picture of depths -> WriteDepth
// (avatar/play/image_bytes.h). The Gaussians are drawn a second time by the same renderer, their
// depths for colours: each pixel then has the mean of the depths, weighted as its colours are.
#pragma once

#include <memory>

#include "avatar/play/player.h"
#include "splat/render/rasterizer.h"

namespace cosplat::plugin {

class DepthPass {
 public:
  DepthPass();
  // `posed` by a player of `avatar`. The picture, over black, stays until the next call.
  const RenderedImage& Draw(const AvatarModel& avatar,
                            const PosedGaussians& posed,
                            const Camera& camera);

 private:
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  Buffer<float> color_dc_;  // [N, 3] that makes the colour a depth
  RenderedImage image_;
};

}  // namespace cosplat::plugin

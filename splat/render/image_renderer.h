// Draws images that nothing is learnt from, one after another: to the host's memory, or to stay.
//
// Gaussians in the rasteriser's stream -> Forward -> Download or Keep. Both wait for what was
// drawn.
#pragma once

#include <memory>

#include "splat/render/device_image.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

class ImageRenderer {
 public:
  explicit ImageRenderer(std::unique_ptr<Rasterizer> rasterizer)
      : rasterizer_(std::move(rasterizer)), tape_(rasterizer_->MakeTape(false)) {}

  // As Rasterizer::Forward.
  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings) {
    rasterizer_->Forward(gaussians, basis, camera, settings, image_, *tape_);
  }
  // What Forward drew; `times` get its phases.
  void Download(RenderedImage& image, PhaseTimes& times);
  // `out`: null, or from here.
  void Keep(AlphaMode alpha, std::unique_ptr<DeviceImage>& out, PhaseTimes& times);

  Stream& stream() const { return rasterizer_->stream(); }

 private:
  void Finish(PhaseTimes& times);

  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
};

}  // namespace cosplat

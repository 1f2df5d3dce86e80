// Renders images without a backward pass: into host memory, or to stay on the device.
//
// Gaussians in the rasteriser's stream -> Forward -> Download or Keep. Both wait for the rendering.
#pragma once

#include <memory>

#include "splat/render/device_image.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

class ImageRenderer {
 public:
  explicit ImageRenderer(std::unique_ptr<Rasterizer> rasterizer)
      : rasterizer_(std::move(rasterizer)), tape_(rasterizer_->MakeTape(false)) {}

  // Same as Rasterizer::Forward.
  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings) {
    rasterizer_->Forward(gaussians, basis, camera, settings, image_, *tape_);
  }
  // Copies the image of the last Forward to the host and adds the phases to `times`.
  void Download(RenderedImage& image, PhaseTimes& times);
  // Keeps the image of the last Forward on the device. `out`: null, or from this renderer.
  void Keep(AlphaMode alpha, std::unique_ptr<DeviceImage>& out, PhaseTimes& times);

  Stream& stream() const { return rasterizer_->stream(); }

 private:
  void Finish(PhaseTimes& times);

  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
};

}  // namespace cosplat

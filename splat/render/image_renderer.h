// Renders images without a backward pass: into host memory, or to stay on the device.
//
// Gaussians in the rasteriser's stream -> Forward -> Download or Keep. Both wait for the rendering,
// and on a device nothing else does after the first image: an image's number of instances is
// expected to be the last one's and an eighth more. One with more is rendered again.
#pragma once

#include <memory>

#include "splat/render/device_image.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

class ImageRenderer {
 public:
  explicit ImageRenderer(std::unique_ptr<Rasterizer> rasterizer);

  // Same as Rasterizer::Forward. The Gaussians must stay until Download or Keep.
  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings);
  // Copies the image of the last Forward to the host and adds the phases to `times`. `image` moves
  // into pinned memory, so that passing the same one again is faster.
  void Download(RenderedImage& image, PhaseTimes& times);
  // Keeps the image of the last Forward on the device. `out`: null, or from this renderer.
  void Keep(AlphaMode alpha, std::unique_ptr<DeviceImage>& out, PhaseTimes& times);

  Stream& stream() const { return rasterizer_->stream(); }

 private:
  struct Frame {
    WorldGaussians gaussians;
    Basis basis;
    Camera camera;
    RenderSettings settings;
  };
  // waits: for the number of instances.
  void Submit(bool waits);
  // Waits for the image and what `copy` submits; does both again if the image had too little
  // capacity.
  template <class Copy>
  void Finish(const Copy& copy, PhaseTimes& times);

  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
  Frame frame_{};                    // of the last Forward
  Readback<InstanceCounts> counts_;  // of the last image that was waited for
  Buffer<uint32_t> exceeded_;        // [1] set by the rasteriser; counts_ says the same
};

}  // namespace cosplat

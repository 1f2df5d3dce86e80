// Draws pictures that nothing is learnt from, one after another: to the host's memory, or to stay.
//
// Gaussians on the device -> Forward -> Download or Keep. Both wait for what was drawn.
#pragma once

#include <memory>

#include "splat/render/alpha_mode.h"
#include "splat/render/cuda/renderer.h"
#include "splat/render/device_picture.h"
#include "splat/render/phase_times.h"

namespace cosplat::cuda {

class PictureRenderer {
 public:
  PictureRenderer() : renderer_(SumOrder::kAny) {}

  // As Renderer::Forward.
  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings);
  // What Forward drew; `times` get its phases.
  void Download(RenderedImage& image, PhaseTimes& times);
  // `out`: null, or from here.
  void Keep(AlphaMode alpha, std::unique_ptr<DevicePicture>& out, PhaseTimes& times);

  const Stream& stream() const { return renderer_.stream(); }

 private:
  void Finish(PhaseTimes& times);

  Renderer renderer_;
  DeviceImage image_;
  Tape tape_;
};

}  // namespace cosplat::cuda

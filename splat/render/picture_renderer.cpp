#include "splat/render/picture_renderer.h"

#include <utility>

namespace cosplat {

void PictureRenderer::Download(RenderedImage& image, PhaseTimes& times) {
  image_.Download(image, stream());
  Finish(times);
}

void PictureRenderer::Keep(AlphaMode alpha,
                           std::unique_ptr<DevicePicture>& out,
                           PhaseTimes& times) {
  if (!out) out = std::make_unique<DevicePicture>(stream());
  out->Write(image_, alpha, stream());
  Finish(times);
}

void PictureRenderer::Finish(PhaseTimes& times) {
  stream().Wait();
  rasterizer_->AddForwardTimes();
  times += std::exchange(rasterizer_->times, {});
}

}  // namespace cosplat

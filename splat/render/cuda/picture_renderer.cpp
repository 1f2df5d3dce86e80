#include "splat/render/cuda/picture_renderer.h"

#include "splat/render/cuda/device_pixels.h"

namespace cosplat::cuda {

void PictureRenderer::Forward(const WorldGaussians& gaussians,
                              Basis basis,
                              const Camera& camera,
                              const RenderSettings& settings) {
  renderer_.Forward(gaussians, basis, camera, settings, false, image_, tape_);
}

void PictureRenderer::Download(RenderedImage& image, PhaseTimes& times) {
  image.width = image_.width;
  image.height = image_.height;
  image.color.resize(image_.color.size());
  image.transmittance.resize(image_.transmittance.size());
  image_.color.Download(image.color.data(), stream().get());
  image_.transmittance.Download(image.transmittance.data(), stream().get());
  Finish(times);
}

void PictureRenderer::Keep(AlphaMode alpha,
                           std::unique_ptr<DevicePicture>& out,
                           PhaseTimes& times) {
  if (!out) out = std::make_unique<DevicePixels>();
  static_cast<DevicePixels&>(*out).Write(image_, alpha, stream().get());
  Finish(times);
}

void PictureRenderer::Finish(PhaseTimes& times) {
  stream().Wait();
  const auto add = [&](Phase phase, Renderer::Mark from, Renderer::Mark to) {
    times.seconds[size_t(phase)] += 1e-3 * renderer_.MillisecondsBetween(from, to);
  };
  add(Phase::kProject, Renderer::kStart, Renderer::kProjected);
  add(Phase::kSort, Renderer::kProjected, Renderer::kSorted);
  add(Phase::kBlend, Renderer::kSorted, Renderer::kBlended);
}

}  // namespace cosplat::cuda

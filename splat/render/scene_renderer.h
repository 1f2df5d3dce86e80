// Renders one scene repeatedly on a device other than the CPU, which keeps the Gaussians.
//
// Gaussians -> SceneRendererOn (splat/render/device.h) -> Draw -> image.
// avatar/play/avatar_renderer.h does the same for avatars.
#pragma once

#include <functional>
#include <memory>

#include "splat/render/image_renderer.h"

namespace cosplat {

class SceneRenderer {
 public:
  // The scene need not outlive the call. Throws Error if the device runs out of memory.
  SceneRenderer(std::unique_ptr<Rasterizer> rasterizer, const Gaussians& scene)
      : images_(std::move(rasterizer)) {
    gaussians_.Upload(scene, images_.stream());
    images_.stream().Wait();
  }

  // Same as Rasterizer::Forward.
  void Draw(const Camera& camera, const RenderSettings& settings, RenderedImage& image) {
    Forward(camera, settings);
    images_.Download(image, times);
  }
  // Like Draw, but the image stays on the device. `out` is created if null; otherwise it must come
  // from this renderer. The background must be black unless `alpha` is AlphaMode::kOpaque.
  void DrawToStay(const Camera& camera,
                  const RenderSettings& settings,
                  AlphaMode alpha,
                  std::unique_ptr<DeviceImage>& out) {
    Forward(camera, settings);
    images_.Keep(alpha, out, times);
  }

  PhaseTimes times;  // project, sort, blend; the caller resets it

 private:
  void Forward(const Camera& camera, const RenderSettings& settings) {
    images_.Forward(ViewOf(gaussians_), gaussians_.basis, camera, settings);
  }

  ImageRenderer images_;
  Gaussians gaussians_;
};

using SceneRendererMaker = std::function<std::unique_ptr<SceneRenderer>(const Gaussians&)>;

}  // namespace cosplat

// Draws one scene again and again where that is not the CPU: the device keeps the Gaussians.
//
// Gaussians -> SceneRendererOn (splat/render/device.h) -> Draw -> picture.
// avatar/play/avatar_renderer.h does the same for avatars.
#pragma once

#include <functional>
#include <memory>

#include "splat/render/alpha_mode.h"
#include "splat/render/device_picture.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

class SceneRenderer {
 public:
  virtual ~SceneRenderer() = default;
  // As Rasterizer::Forward.
  virtual void Draw(const Camera& camera, const RenderSettings& settings, RenderedImage& image) = 0;
  // The same, but the picture stays on the device; made where `out` is null, otherwise `out` is of
  // this renderer. The background must be black but with AlphaMode::kOpaque.
  virtual void DrawToStay(const Camera& camera,
                          const RenderSettings& settings,
                          AlphaMode alpha,
                          std::unique_ptr<DevicePicture>& out) = 0;

  PhaseTimes times;  // project, sort, blend; the caller resets it
};

// Of one scene, which need not outlive the call.
using SceneRendererMaker = std::function<std::unique_ptr<SceneRenderer>(const Gaussians&)>;

}  // namespace cosplat

#include "splat/render/cuda/device_scene.h"

#include "splat/render/cuda/device_gaussians.h"
#include "splat/render/cuda/picture_renderer.h"

namespace cosplat::cuda {
namespace {

class DeviceScene : public SceneRenderer {
 public:
  explicit DeviceScene(const Gaussians& scene) : basis_(scene.basis) {
    gaussians_.Upload(scene, pictures_.stream().get());
    pictures_.stream().Wait();  // for the scene's memory
  }

  void Draw(const Camera& camera, const RenderSettings& settings, RenderedImage& image) override {
    pictures_.Forward(gaussians_.View(), basis_, camera, settings);
    pictures_.Download(image, times);
  }
  void DrawToStay(const Camera& camera,
                  const RenderSettings& settings,
                  AlphaMode alpha,
                  std::unique_ptr<DevicePicture>& out) override {
    pictures_.Forward(gaussians_.View(), basis_, camera, settings);
    pictures_.Keep(alpha, out, times);
  }

 private:
  Basis basis_;
  PictureRenderer pictures_;
  DeviceGaussians gaussians_;
};

}  // namespace

std::unique_ptr<SceneRenderer> MakeDeviceScene(const Gaussians& scene) {
  return std::make_unique<DeviceScene>(scene);
}

}  // namespace cosplat::cuda

#include "avatar/play/cuda/device_avatar_renderer.h"

#include "avatar/play/cuda/device_poser.h"
#include "avatar/surface/cuda/device_binding.h"
#include "splat/render/cuda/picture_renderer.h"

namespace cosplat::cuda {
namespace {

class DeviceAvatarRenderer : public AvatarRenderer {
 public:
  DeviceAvatarRenderer(const AvatarModel& avatar, const AvatarPosing& posing, DirectionStore& store)
      : basis_(avatar.gaussians.basis),
        color_frame_(avatar.color_frame),
        poser_(posing, store, stream()),
        surface_(Surface(avatar.mesh), stream()) {
    gaussians_.Upload(avatar.gaussians, stream());
    embedding_.Upload(avatar, surface_.face_count(), stream());
    pictures_.stream().Wait();  // for the avatar's memory
  }

  void Draw(const FlameRig<float>& rig,
            uint64_t placement,
            const Camera& camera,
            const RenderSettings& settings,
            RenderedImage& image) override {
    Place(rig, placement);
    Forward(camera, settings);
    pictures_.Download(image, times);
  }
  void DrawToStay(const FlameRig<float>& rig,
                  uint64_t placement,
                  const Camera& camera,
                  const RenderSettings& settings,
                  AlphaMode alpha,
                  std::unique_ptr<DevicePicture>& out) override {
    Place(rig, placement);
    Forward(camera, settings);
    pictures_.Keep(alpha, out, times);
  }

 private:
  void Place(const FlameRig<float>& rig, uint64_t placement) {
    if (placement != 0 && placement == placed_) return;
    placed_ = 0;
    surface_.Pose(poser_.Pose(rig, stream()).data(), stream());
    binding_.Bind(gaussians_, embedding_, surface_, posed_, stream());
    placed_ = placement;
  }
  void Forward(const Camera& camera, const RenderSettings& settings) {
    pictures_.Forward(posed_.View(gaussians_, color_frame_), basis_, camera, settings);
  }
  cudaStream_t stream() const { return pictures_.stream().get(); }

  Basis basis_;
  ColorFrame color_frame_;
  PictureRenderer pictures_;
  DevicePoser poser_;
  DeviceSurface surface_;
  DeviceGaussians gaussians_;
  DeviceEmbedding embedding_;
  DeviceBinding binding_;
  DevicePosed posed_;
  uint64_t placed_ = 0;  // what posed_ is of
};

}  // namespace

AvatarRendererMaker MakeDeviceRenderers() {
  return [store = std::make_shared<DirectionStore>()](const AvatarModel& avatar,
                                                      const AvatarPosing& posing) {
    return std::make_unique<DeviceAvatarRenderer>(avatar, posing, *store);
  };
}

}  // namespace cosplat::cuda

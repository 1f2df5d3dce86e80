#include "avatar/cuda/device_drawer.h"

#include "avatar/cuda/device_binding.h"
#include "avatar/cuda/device_poser.h"
#include "splat/cuda/renderer.h"

namespace cosplat::cuda {
namespace {

class DeviceDrawer : public AvatarDrawer {
 public:
  DeviceDrawer(const AvatarModel& avatar, const AvatarPosing& posing, DirectionStore& store)
      : basis_(avatar.gaussians.basis),
        color_frame_(avatar.color_frame),
        renderer_(SumOrder::kAny),
        poser_(posing, store, stream()),
        surface_(Surface(avatar.mesh), stream()) {
    gaussians_.Upload(avatar.gaussians, stream());
    embedding_.Upload(avatar, surface_.face_count(), stream());
    renderer_.stream().Wait();  // for the avatar's memory
  }

  void Draw(const FlameRig<float>& rig,
            uint64_t placement,
            const Camera& camera,
            const RenderSettings& settings,
            RenderedImage& image) override {
    if (placement == 0 || placement != placed_) Place(rig);
    placed_ = placement;
    renderer_.Forward(
        posed_.View(gaussians_, color_frame_), basis_, camera, settings, false, image_, tape_);
    image.width = image_.width;
    image.height = image_.height;
    image.color.resize(image_.color.size());
    image.transmittance.resize(image_.transmittance.size());
    image_.color.Download(image.color.data(), stream());
    image_.transmittance.Download(image.transmittance.data(), stream());
    renderer_.stream().Wait();
    AddTime(Phase::kProject, Renderer::kStart, Renderer::kProjected);
    AddTime(Phase::kSort, Renderer::kProjected, Renderer::kSorted);
    AddTime(Phase::kBlend, Renderer::kSorted, Renderer::kBlended);
  }

 private:
  void Place(const FlameRig<float>& rig) {
    placed_ = 0;
    surface_.Pose(poser_.Pose(rig, stream()).data(), stream());
    binding_.Bind(gaussians_, embedding_, surface_, posed_, stream());
  }
  void AddTime(Phase phase, Renderer::Mark from, Renderer::Mark to) {
    times.seconds[size_t(phase)] += 1e-3 * renderer_.MillisecondsBetween(from, to);
  }
  cudaStream_t stream() const { return renderer_.stream().get(); }

  Basis basis_;
  ColorFrame color_frame_;
  Renderer renderer_;
  DevicePoser poser_;
  DeviceSurface surface_;
  DeviceGaussians gaussians_;
  DeviceEmbedding embedding_;
  DeviceBinding binding_;
  DevicePosed posed_;
  uint64_t placed_ = 0;  // what posed_ is of
  DeviceImage image_;
  Tape tape_;
};

}  // namespace

AvatarDrawerMaker MakeDeviceDrawers() {
  return [store = std::make_shared<DirectionStore>()](const AvatarModel& avatar,
                                                      const AvatarPosing& posing) {
    return std::make_unique<DeviceDrawer>(avatar, posing, *store);
  };
}

}  // namespace cosplat::cuda

// Draws an avatar for a Player where that is not the CPU: everything but the joints stays on the
// device.
//
// Player: parameters -> FlameRig (joints posed, on the CPU) -> AvatarRenderer: vertices, surface,
// binding, rasteriser -> image. avatar/play/avatar_renderer.h chooses.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "avatar/model/avatar_model.h"
#include "avatar/play/rig_poser.h"
#include "avatar/surface/binding.h"
#include "splat/render/device.h"
#include "splat/render/image_renderer.h"

namespace cosplat {

class AvatarRenderer {
 public:
  // Arrays of the avatar fit each other (CheckEmbedding); it need not outlive the call. Of its
  // posing FLAME's directions do, at the same place: renderers may share what `store` has of them.
  // Throws Error where the avatar has the released rule, or the device has no room.
  AvatarRenderer(std::unique_ptr<Rasterizer> rasterizer,
                 const AvatarModel& avatar,
                 const AvatarPosing& posing,
                 DirectionStore& store);

  // As Rasterizer::Forward, of the avatar in this pose, within float's range (PosingReach).
  // `placement` is another one where the pose is; 0 is none.
  void Draw(const FlameRig<float>& rig,
            uint64_t placement,
            const Camera& camera,
            const RenderSettings& settings,
            RenderedImage& image);
  // The same, but the image stays on the device; made where `out` is null, otherwise `out` is of
  // this renderer. The background must be black but with AlphaMode::kOpaque.
  void DrawToStay(const FlameRig<float>& rig,
                  uint64_t placement,
                  const Camera& camera,
                  const RenderSettings& settings,
                  AlphaMode alpha,
                  std::unique_ptr<DeviceImage>& out);

  PhaseTimes times;  // project, sort, blend; the caller resets it

 private:
  void Place(const FlameRig<float>& rig, uint64_t placement);
  void Forward(const Camera& camera, const RenderSettings& settings);

  ImageRenderer images_;
  ColorFrame color_frame_;
  RigPoser poser_;
  Surface surface_;
  Gaussians gaussians_;
  Embedding embedding_;
  PosedGaussians posed_;
  uint64_t placed_ = 0;  // what posed_ is of
};

using AvatarRendererMaker =
    std::function<std::unique_ptr<AvatarRenderer>(const AvatarModel&, const AvatarPosing&)>;

// Who draws on a device for a Player.

// For PlayerSettings; empty for the CPU. Players of the same FlameModel that get copies of one
// share the model's directions there. Making a renderer throws Error for an avatar with the
// released rule (avatar/surface/binding.h), which is the CPU's to draw.
AvatarRendererMaker AvatarRendererOn(Device device);

}  // namespace cosplat

// Renders an avatar on a device for a Player: everything except posing the joints is done there.
//
// Player: parameters -> FlameRig (joints posed, on the CPU) -> AvatarRenderer: vertices, surface,
// binding, rasteriser -> image.
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
  // The avatar's arrays must be consistent (CheckEmbedding); the avatar need not outlive the call.
  // FLAME's directions in `posing` must outlive the renderer, at the same address: renderers may
  // share the copies in `store`. Throws Error if the avatar has the released rule or the device is
  // out of memory.
  AvatarRenderer(std::unique_ptr<Rasterizer> rasterizer,
                 const AvatarModel& avatar,
                 const AvatarPosing& posing,
                 DirectionStore& store);

  // As Rasterizer::Forward, of the avatar in this pose, which must stay within float's range
  // (PosingReach). placement: identifies the pose; the avatar is not posed again while it is
  // unchanged and not 0.
  void Draw(const AvatarRig& rig,
            uint64_t placement,
            const Camera& camera,
            const RenderSettings& settings,
            RenderedImage& image);
  // The same, but the image stays on the device. out: null to create an image, otherwise one made
  // by this renderer. The background must be black except with AlphaMode::kOpaque.
  void DrawToStay(const AvatarRig& rig,
                  uint64_t placement,
                  const Camera& camera,
                  const RenderSettings& settings,
                  AlphaMode alpha,
                  std::unique_ptr<DeviceImage>& out);

  PhaseTimes times;  // project, sort, blend; reset by the caller

 private:
  void Pose(const AvatarRig& rig, uint64_t placement);
  void Forward(const Camera& camera, const RenderSettings& settings);

  ImageRenderer images_;
  ColorFrame color_frame_;
  RigPoser poser_;
  Surface surface_;
  Gaussians gaussians_;
  Embedding embedding_;
  Buffer<float> weights_, light_;
  PosedGaussians posed_;
  uint64_t placed_ = 0;  // the placement of posed_
};

using AvatarRendererMaker =
    std::function<std::unique_ptr<AvatarRenderer>(const AvatarModel&, const AvatarPosing&)>;

// For PlayerSettings: creates renderers on the device; empty for the CPU. Players of the same
// FlameModel that use copies of one maker share the model's directions on the device. Creating a
// renderer throws Error for an avatar with the released rule (avatar/surface/binding.h), which only
// the CPU supports.
AvatarRendererMaker AvatarRendererOn(Device device);

}  // namespace cosplat

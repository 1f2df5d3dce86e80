// Renders an avatar: FLAME parameters + camera -> image. Links no training code.
//
// AvatarModel -> Player: Pose (pose -> surface -> bind) -> PosedAvatar -> Draw (rasterise) ->
// image. Results that have not changed since the last frame are reused; every image is
// bit-identical to that of a new player. avatar/play/playback.h runs both halves in parallel.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "avatar/model/avatar_model.h"
#include "avatar/play/avatar_renderer.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/surface.h"
#include "flame/model.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

struct PlayerSettings {
  // Renders a quarter of the pixels and enlarges the image (avatar/play/preview.h).
  bool half_resolution = false;
  // Creates the renderer for a device (avatar/play/avatar_renderer.h); empty for the CPU.
  AvatarRendererMaker make_renderer{};
};

// An avatar's Gaussians in the world, for one frame's parameters. Player::Pose fills it.
class PosedAvatar {
 public:
  // Whether it was placed for bit-identical parameters. Shape and static offset are not compared,
  // since the avatar has its own.
  bool IsFor(const FlameParams& params) const;

 private:
  friend class Player;
  uint64_t id_ = 0;        // of the call of Pose that filled it; 0: none
  uint64_t posed_id_ = 0;  // the id_ that vertices_ belong to
  uint64_t bound_id_ = 0;  // the id_ that gaussians_ belong to
  FlameParams params_;
  AvatarRig rig_;                // for rendering on a device
  std::vector<float> vertices_;  // [V, 3] metres
  PosedGaussians gaussians_;
};

class Player {
 public:
  // `avatar.mesh` must be set (by AttachMesh if the avatar's file does not contain it). Keeps a
  // reference to `flame`. Throws Error when avatar and model do not match.
  Player(AvatarModel avatar, const FlameModel& flame, PlayerSettings settings = {});

  // Pose and Draw are the two halves of a frame. They may run in parallel, one call of each at a
  // time, as long as the avatar being drawn is not the one being placed.
  //
  // Expression coefficients that the model does not have are ignored. Throws Error when a parameter
  // is not finite; `out` then keeps its content. Does nothing if `out.IsFor(params)`: `out` must be
  // new or have been placed by this player.
  void Pose(const FlameParams& params, PosedAvatar& out);
  // The posed vertices, [V, 3] metres, and the Gaussians of an avatar placed by this player. When
  // rendering on a device, which has its own, they are computed by these calls on the CPU, which
  // therefore must not run in parallel with Pose.
  const std::vector<float>& VerticesOf(PosedAvatar& placed);
  const PosedGaussians& GaussiansOf(PosedAvatar& placed);
  // Renders an avatar placed by this player over a background. The image is owned by the player and
  // valid until the next call; it is reused for the same avatar, camera and background.
  const RenderedImage& Draw(const PosedAvatar& placed,
                            const Camera& camera,
                            const std::array<float, 3>& background);
  // Whether images can stay on the device: the player renders on one, at full resolution.
  bool DrawsOnDevice() const { return renderer_ && !half_resolution_; }
  // As Draw, but the image stays on the device and is rendered on every call. out: null, or an
  // image of this player. The background must be black except with AlphaMode::kOpaque. Throws Error
  // unless DrawsOnDevice().
  void DrawToStay(const PosedAvatar& placed,
                  const Camera& camera,
                  const std::array<float, 3>& background,
                  AlphaMode alpha,
                  std::unique_ptr<DeviceImage>& out);

  // Pose and Draw; throws as they do, and `out` then keeps its content.
  void RenderOver(const FlameParams& params,
                  const Camera& camera,
                  const std::array<float, 3>& background,
                  RenderedImage& out);

  // RGBA bytes with straight alpha. The first overload reuses the memory of `out`.
  void Render(const FlameParams& params, const Camera& camera, Image8& out);
  Image8 Render(const FlameParams& params, const Camera& camera);

  // The avatar, with its Gaussians sorted by degree (splat/gaussians.h).
  const AvatarModel& avatar() const { return avatar_; }
  // Posed vertices of the last frame of RenderOver or Render, as VerticesOf.
  const std::vector<float>& vertices() { return VerticesOf(placed_); }
  // Seconds per phase of rendering; reset by the caller.
  PhaseTimes& times() { return renderer_ ? renderer_->times : rasterizer_->times; }

 private:
  struct Image {
    uint64_t id = 0;  // of the PosedAvatar; 0: none yet
    Camera camera;
    std::array<float, 3> background{};
    RenderedImage image;
  };

  void Prepare(PosedAvatar& placed);
  void PoseAndBind(PosedAvatar& placed);
  void BindInto(PosedAvatar& placed);
  void DrawInto(const PosedAvatar& placed,
                const Camera& camera,
                const RenderSettings& settings,
                RenderedImage& image);

  AvatarModel avatar_;
  bool half_resolution_;
  AvatarPoser poser_;
  AvatarPoser::Parameters frame_;  // of the last Pose; reused for its memory
  std::vector<float> weights_;     // of corrections; reused for its memory
  Surface surface_;
  uint64_t last_id_ = 0;
  PosedAvatar placed_;
  std::unique_ptr<AvatarRenderer> renderer_;  // null: rendered on the CPU by rasterizer_ and tape_
  std::optional<PosingReach> reach_;          // set if renderer_ is
  AvatarRig rig_;                             // of the next Pose; reused for its memory
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  Image last_;
  RenderedImage half_;
};

// RGBA bytes with straight alpha of an image over black. Equal to ToBytes(image.ToStraightAlpha()),
// but in parallel and without the intermediate image.
void ToStraightAlphaBytes(const RenderedImage& image, Image8& out);

}  // namespace cosplat

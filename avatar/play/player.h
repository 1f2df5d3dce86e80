// Plays an avatar: FLAME parameters + camera -> image. Links no training code.
//
// AvatarModel -> Player: Place (pose -> surface -> bind) -> PlacedAvatar -> Draw (rasterise) ->
// image. What did not change since the last frame is not done again; every image has the bits
// that a new player would give it. avatar/play/playback.h runs both halves beside each other.
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
  // Draws a quarter of the pixels and enlarges them (avatar/play/preview.h).
  bool half_resolution = false;
  // Who draws (avatar/play/avatar_renderer.h); empty: the CPU.
  AvatarRendererMaker make_renderer{};
};

// An avatar's Gaussians in the world, for one frame's parameters. Player::Place fills it.
class PlacedAvatar {
 public:
  // Whether it was placed for parameters with the same bits. Shape and static offset do not count:
  // they are the avatar's own.
  bool IsFor(const FlameParams& params) const;

 private:
  friend class Player;
  uint64_t id_ = 0;        // which Place filled it; 0: none
  uint64_t posed_id_ = 0;  // of which vertices_ are
  uint64_t bound_id_ = 0;  // of which gaussians_ are
  FlameParams params_;
  FlameRig<float> rig_;          // where a device draws
  std::vector<float> vertices_;  // [V, 3] metres
  PosedGaussians gaussians_;
};

class Player {
 public:
  // `avatar.mesh` must hold the canonical mesh (AttachMesh where its file does not). Keeps a
  // reference to `flame`. Throws Error when the two do not fit each other.
  Player(AvatarModel avatar, const FlameModel& flame, PlayerSettings settings = {});

  // The two halves of a frame. They may run at the same time, each one call at a time, as long as
  // the avatar that is drawn is not the one being placed.
  //
  // Expression coefficients beyond the model's are left out. Throws Error when a parameter is not
  // finite; `out` then keeps its last content. Nothing is done where `out.IsFor(params)`: it must
  // be new or have been placed by this player.
  void Place(const FlameParams& params, PlacedAvatar& out);
  // The posed vertices, [V, 3] metres, and the Gaussians of what this player placed. Where a device
  // draws, it keeps its own, and these are posed and bound now, on the CPU: not beside Place.
  const std::vector<float>& VerticesOf(PlacedAvatar& placed);
  const PosedGaussians& GaussiansOf(PlacedAvatar& placed);
  // Over a background; `placed` by this player. The image is the player's own: it stays until the
  // next call and is not drawn again for the same avatar, camera and background.
  const RenderedImage& Draw(const PlacedAvatar& placed,
                            const Camera& camera,
                            const std::array<float, 3>& background);
  // Whether images can stay where they are drawn: a device draws, in full size.
  bool DrawsOnDevice() const { return renderer_ && !half_resolution_; }
  // As Draw, but the image stays on the device and is drawn each time. `out`: null, or of this
  // player. The background must be black but with AlphaMode::kOpaque. Throws Error without
  // DrawsOnDevice.
  void DrawToStay(const PlacedAvatar& placed,
                  const Camera& camera,
                  const std::array<float, 3>& background,
                  AlphaMode alpha,
                  std::unique_ptr<DeviceImage>& out);

  // Place and Draw; throws as they do, and `out` then keeps its last content.
  void RenderOver(const FlameParams& params,
                  const Camera& camera,
                  const std::array<float, 3>& background,
                  RenderedImage& out);

  // RGBA bytes with straight alpha. The first keeps the memory of `out`.
  void Render(const FlameParams& params, const Camera& camera, Image8& out);
  Image8 Render(const FlameParams& params, const Camera& camera);

  // Its Gaussians in the order of their degrees (splat/gaussians.h).
  const AvatarModel& avatar() const { return avatar_; }
  // Posed vertices of the last frame of RenderOver or Render, as VerticesOf.
  const std::vector<float>& vertices() { return VerticesOf(placed_); }
  // Seconds per phase of drawing; the caller resets it.
  PhaseTimes& times() { return renderer_ ? renderer_->times : rasterizer_->times; }

 private:
  struct Image {
    uint64_t id = 0;  // of the PlacedAvatar; 0: none yet
    Camera camera;
    std::array<float, 3> background{};
    RenderedImage image;
  };

  void Prepare(PlacedAvatar& placed);
  void PoseAndBind(PlacedAvatar& placed);
  void BindInto(PlacedAvatar& placed);
  void DrawInto(const PlacedAvatar& placed,
                const Camera& camera,
                const RenderSettings& settings,
                RenderedImage& image);

  AvatarModel avatar_;
  bool half_resolution_;
  AvatarPoser poser_;
  AvatarPoser::Frame frame_;  // of the last Place; keeps its memory
  Surface surface_;
  uint64_t last_id_ = 0;
  PlacedAvatar placed_;
  std::unique_ptr<AvatarRenderer> renderer_;  // null: the CPU draws, by the two after the next two
  std::optional<PosingReach> reach_;          // where there is one
  FlameRig<float> rig_;                       // of the next Place; keeps its memory
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  Image last_;
  RenderedImage half_;
};

// RGBA bytes with straight alpha of an image over black: those of
// ToBytes(image.ToStraightAlpha()), over the cores and without what lies between.
void ToStraightAlphaBytes(const RenderedImage& image, Image8& out);

}  // namespace cosplat

// Plays an avatar: FLAME parameters + camera -> picture. Links no training code.
//
// AvatarModel -> Player::Render(parameters, camera): pose -> surface -> bind -> rasterise.
#pragma once

#include <memory>

#include "avatar/avatar_mesh.h"
#include "avatar/avatar_model.h"
#include "avatar/binding.h"
#include "avatar/surface.h"
#include "flame/model.h"
#include "splat/rasterizer.h"

namespace cosplat {

class Player {
 public:
  // `avatar.mesh` must hold the canonical mesh (AttachMesh where its file does not). Keeps a
  // reference to `flame`. Throws Error when the two do not fit each other.
  Player(AvatarModel avatar, const FlameModel& flame);

  // Over a background. Expression coefficients beyond the model's are left out. Throws Error when a
  // parameter is not finite; the picture then keeps its last content.
  void RenderOver(const FlameParams& params,
                  const Camera& camera,
                  const std::array<float, 3>& background,
                  RenderedImage& out);

  // RGBA bytes with straight alpha.
  Image8 Render(const FlameParams& params, const Camera& camera);

  const AvatarModel& avatar() const { return avatar_; }
  // Posed vertices of the last frame, [V, 3] metres.
  const std::vector<float>& vertices() const { return vertices_; }

 private:
  AvatarModel avatar_;
  AvatarPoser poser_;
  Surface surface_;
  PosedGaussians posed_;
  std::vector<float> vertices_;
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
};

// The Gaussians of one posed surface as the rasteriser takes them.
WorldGaussians PosedView(const Gaussians& gaussians,
                         const PosedGaussians& posed,
                         ColorFrame color_frame);

}  // namespace cosplat

#include "avatar/plugin/depth_pass.h"

#include "splat/basis_constants.h"

namespace cosplat::plugin {

DepthPass::DepthPass() : rasterizer_(MakeCpuRasterizer()), tape_(rasterizer_->MakeTape()) {}

const RenderedImage& DepthPass::Draw(const AvatarModel& avatar,
                                     const PosedGaussians& posed,
                                     const Camera& camera) {
  const Buffer<float>& position = posed.position;
  const float* r = &camera.rotation[6];
  // Inverts colour = 1/2 + K0 dc (splat/math/dcsh.h).
  const float scale = 1 / BasisConstants(Basis::kSh)[0];
  color_dc_.resize(position.size());
  for (size_t i = 0; i < position.size(); i += 3) {
    const float depth = r[0] * position[i] + r[1] * position[i + 1] + r[2] * position[i + 2] +
                        camera.translation[2];
    for (size_t c = 0; c < 3; ++c) color_dc_[i + c] = (depth - 0.5f) * scale;
  }
  WorldGaussians view =
      PosedView(avatar.gaussians, posed, ColorFrame::kWorld);  // depths do not depend on direction
  view.color_dc = color_dc_.data();
  view.color_rest = nullptr;
  view.rest_width = 0;
  view.degree = nullptr;
  rasterizer_->Forward(view, Basis::kSh, camera, {{0, 0, 0}, 0}, image_, *tape_);
  return image_;
}

}  // namespace cosplat::plugin

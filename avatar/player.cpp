#include "avatar/player.h"

#include "splat/base/error.h"
#include "splat/base/image_io.h"

namespace cosplat {

Player::Player(AvatarModel avatar, const FlameModel& flame)
    : avatar_(std::move(avatar)),
      poser_(flame, avatar_.shape, avatar_.static_offset, avatar_.bust),
      surface_(avatar_.mesh),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape()) {
  if (surface_.vertex_count() != poser_.vertex_count())
    throw Error(flame.name,
                "vertices",
                std::to_string(poser_.vertex_count()) + " where the avatar's mesh has " +
                    std::to_string(surface_.vertex_count()));
}

void Player::RenderOver(const FlameParams& params,
                        const Camera& camera,
                        const std::array<float, 3>& background,
                        RenderedImage& out) {
  poser_.Forward(poser_.FrameFor(params), vertices_);
  surface_.Pose(vertices_);
  Bind(avatar_, surface_, posed_);
  rasterizer_->Forward(PosedView(avatar_.gaussians, posed_, avatar_.color_frame),
                       avatar_.gaussians.basis,
                       camera,
                       {background, avatar_.gaussians.degree},
                       out,
                       *tape_);
}

Image8 Player::Render(const FlameParams& params, const Camera& camera) {
  RenderedImage image;
  RenderOver(params, camera, {0, 0, 0}, image);
  return ToBytes(image.ToStraightAlpha());
}

WorldGaussians PosedView(const Gaussians& gaussians,
                         const PosedGaussians& posed,
                         ColorFrame color_frame) {
  WorldGaussians view = ViewOf(gaussians);
  view.position = posed.position.data();
  view.rotation = posed.rotation.data();
  view.scale_log = posed.scale_log.data();
  if (color_frame == ColorFrame::kSurface) view.color_frame = posed.frame.data();
  return view;
}

}  // namespace cosplat

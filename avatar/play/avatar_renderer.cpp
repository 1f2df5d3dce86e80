#include "avatar/play/avatar_renderer.h"

#include <utility>

namespace cosplat {

AvatarRenderer::AvatarRenderer(std::unique_ptr<Rasterizer> rasterizer,
                               const AvatarModel& avatar,
                               const AvatarPosing& posing,
                               DirectionStore& store)
    : images_(std::move(rasterizer)),
      color_frame_(avatar.color_frame),
      poser_(posing, store, images_.stream()),
      surface_(avatar.mesh, images_.stream()) {
  gaussians_.Upload(avatar.gaussians, images_.stream());
  UploadEmbedding(avatar.embedding, embedding_, images_.stream());
  if (avatar.light) light_.Upload(*avatar.light, images_.stream());
  images_.stream().Wait();  // the avatar may be freed after this call
}

void AvatarRenderer::Draw(const AvatarRig& rig,
                          uint64_t placement,
                          const Camera& camera,
                          const RenderSettings& settings,
                          RenderedImage& image) {
  Pose(rig, placement);
  Forward(camera, settings);
  images_.Download(image, times);
}

void AvatarRenderer::DrawToStay(const AvatarRig& rig,
                                uint64_t placement,
                                const Camera& camera,
                                const RenderSettings& settings,
                                AlphaMode alpha,
                                std::unique_ptr<DeviceImage>& out) {
  Pose(rig, placement);
  Forward(camera, settings);
  images_.Keep(alpha, out, times);
}

void AvatarRenderer::Pose(const AvatarRig& rig, uint64_t placement) {
  if (placement != 0 && placement == placed_) return;
  placed_ = 0;
  surface_.Pose(poser_.Pose(rig, images_.stream()));
  weights_.Upload(rig.weights, images_.stream());
  Bind(gaussians_,
       embedding_,
       surface_,
       posed_,
       {std::as_const(weights_).view(), std::as_const(light_).view()});
  placed_ = placement;
}

void AvatarRenderer::Forward(const Camera& camera, const RenderSettings& settings) {
  images_.Forward(PosedView(gaussians_, posed_, color_frame_), gaussians_.basis, camera, settings);
}

}  // namespace cosplat

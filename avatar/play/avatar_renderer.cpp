#include "avatar/play/avatar_renderer.h"

#include <utility>

namespace cosplat {

AvatarRenderer::AvatarRenderer(std::unique_ptr<Rasterizer> rasterizer,
                               const AvatarModel& avatar,
                               const AvatarPosing& posing,
                               DirectionStore& store)
    : pictures_(std::move(rasterizer)),
      color_frame_(avatar.color_frame),
      poser_(posing, store, pictures_.stream()),
      surface_(avatar.mesh, pictures_.stream()) {
  gaussians_.Upload(avatar.gaussians, pictures_.stream());
  UploadEmbedding(avatar.embedding, embedding_, pictures_.stream());
  pictures_.stream().Wait();  // for the avatar's memory
}

void AvatarRenderer::Draw(const FlameRig<float>& rig,
                          uint64_t placement,
                          const Camera& camera,
                          const RenderSettings& settings,
                          RenderedImage& image) {
  Place(rig, placement);
  Forward(camera, settings);
  pictures_.Download(image, times);
}

void AvatarRenderer::DrawToStay(const FlameRig<float>& rig,
                                uint64_t placement,
                                const Camera& camera,
                                const RenderSettings& settings,
                                AlphaMode alpha,
                                std::unique_ptr<DevicePicture>& out) {
  Place(rig, placement);
  Forward(camera, settings);
  pictures_.Keep(alpha, out, times);
}

void AvatarRenderer::Place(const FlameRig<float>& rig, uint64_t placement) {
  if (placement != 0 && placement == placed_) return;
  placed_ = 0;
  surface_.Pose(poser_.Pose(rig, pictures_.stream()));
  Bind(gaussians_, embedding_, surface_, posed_);
  placed_ = placement;
}

void AvatarRenderer::Forward(const Camera& camera, const RenderSettings& settings) {
  pictures_.Forward(
      PosedView(gaussians_, posed_, color_frame_), gaussians_.basis, camera, settings);
}

}  // namespace cosplat

// Density control of an avatar: split Gaussians are re-embedded, and pruning must not open holes.
#include <algorithm>

#include "avatar/surface/silhouette.h"
#include "avatar/train/avatar_subject.h"

namespace cosplat {

void AvatarSubject::Move(View<const float> offsets, size_t first, Gaussians& gaussians, Stream&) {
  embedded_.Move(surface_, !IsOurs(), offsets, first, gaussians);
}

const Buffer<uint8_t>& AvatarSubject::SilhouetteOf(size_t k) {
  const bool moves = settings_.refine_track || !bust_track_.empty();
  if (!silhouettes_[k].empty() && !moves) return silhouettes_[k];
  const size_t f = math::HoleFrame(k, track_.frames.size());
  if (!bust_track_.empty()) track_.frames[f].params.bust = bust_track_.PoseOf(f);
  const std::vector<uint8_t> silhouette =
      MeshSilhouette(track_.VerticesOf(f), subject_.mesh.faces, frames_[f].camera);
  silhouettes_[k].Refill(silhouette.size(), *stream_);
  stream_->Send(silhouettes_[k].data(), silhouette.data(), silhouette.size());
  return silhouettes_[k];
}

// Renders alpha without the Gaussians to be removed. Where that opens a hole inside the silhouette,
// the Gaussians near it whose triangles would become empty are kept.
void AvatarSubject::Veto(const Gaussians& gaussians,
                         const Canvas* canvas,
                         View<uint8_t> unwanted,
                         Stream& stream) {
  const size_t faces = subject_.mesh.faces.size();
  if (!IsOurs() || !canvas ||
      !holes_.Begin(gaussians,
                    embedded_.scratch().by_face.Of(embedded_.embedding(), faces, stream),
                    faces,
                    unwanted,
                    stream))
    return;
  for (size_t k = 0; k < std::min(math::kHoleFrames, track_.frames.size()); ++k) {
    const size_t f = math::HoleFrame(k, track_.frames.size());
    WorldGaussians world = ToWorld(gaussians, f);
    world.color_frame = nullptr;  // colours are not used
    holes_.Spare(*canvas, world, gaussians.basis, frames_[f].camera, SilhouetteOf(k), unwanted);
  }
}

}  // namespace cosplat

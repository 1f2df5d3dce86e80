// Density control of an avatar: split Gaussians are re-embedded, and pruning must not open holes.
#include <algorithm>

#include "avatar/surface/kernels/place.h"
#include "avatar/surface/silhouette.h"
#include "avatar/train/trainer.h"
#include "splat/device/for_each.h"
#include "splat/device/gather.h"

namespace cosplat {

void AvatarSubject::Gather(View<const uint32_t> source, Stream& stream) {
  GatherRows(embedding_.triangle, spare_triangle_, 1, source, source.count, stream);
  GatherRows(embedding_.barycentric, spare_barycentric_, 1, source, source.count, stream);
  GatherRows(first_triangle_, spare_triangle_, 1, source, source.count, stream);
  TrianglesChanged();
}

// In the canonical frame.
View<const float> AvatarSubject::Centers(const Gaussians& gaussians, Stream& stream) {
  centers_.Refill(3 * gaussians.size(), stream);
  ForEach(gaussians.size(),
          stream,
          PlaceEach{surface_.CanonicalArrays(),
                    embedding_.triangle.data(),
                    embedding_.barycentric_data(),
                    gaussians.values[kPosition].view(),
                    centers_.view()});
  return std::as_const(centers_).view();
}

void AvatarSubject::Move(View<const float> offsets,
                         size_t first,
                         Gaussians& gaussians,
                         Stream& stream) {
  ForEach(std::min(searches_.size(), offsets.count / 3),
          stream,
          MoveEach{surface_.CanonicalArrays(),
                   offsets,
                   first,
                   !IsOurs(),
                   searches_.view(),
                   embedding_.triangle.data(),
                   embedding_.barycentric_data(),
                   gaussians.values[kPosition].view()});
  TrianglesChanged();
}

std::vector<int32_t> AvatarSubject::Groups(Stream& stream) {
  return embedding_.triangle.Downloaded(stream);
}

const Buffer<uint8_t>& AvatarSubject::SilhouetteOf(size_t k) {
  const bool moves = settings_.refine_track || !bust_track_.empty();
  if (!silhouettes_[k].empty() && !moves) return silhouettes_[k];
  const size_t f = math::HoleFrame(k, frames_.size());
  if (!bust_track_.empty()) track_[f].params.bust = bust_track_.PoseOf(f);
  const std::vector<uint8_t> silhouette =
      MeshSilhouette(VerticesOf(f), mesh_.faces, frames_[f].camera);
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
  const size_t faces = mesh_.faces.size();
  if (!IsOurs() || !canvas ||
      !holes_.Begin(
          gaussians, scratch_.by_face.Of(embedding_, faces, stream), faces, unwanted, stream))
    return;
  for (size_t k = 0; k < std::min(math::kHoleFrames, frames_.size()); ++k) {
    const size_t f = math::HoleFrame(k, frames_.size());
    WorldGaussians world = ToWorld(gaussians, f);
    world.color_frame = nullptr;  // colours are not used
    holes_.Spare(*canvas, world, gaussians.basis, frames_[f].camera, SilhouetteOf(k), unwanted);
  }
}

}  // namespace cosplat

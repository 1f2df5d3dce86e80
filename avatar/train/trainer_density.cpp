// Density control of an avatar: what splits is re-embedded, and what goes may not tear a hole.
#include <algorithm>

#include "avatar/play/player.h"
#include "avatar/surface/kernels/holes.h"
#include "avatar/surface/kernels/place.h"
#include "avatar/surface/silhouette.h"
#include "avatar/train/trainer.h"
#include "splat/render/kernels/project.h"
#include "splat/render/kernels/view_parameters.h"

namespace cosplat {
void AvatarSubject::Gather(const std::vector<uint32_t>& source) {
  Embedding gathered;
  gathered.released = state_.embedding.released;
  std::vector<int32_t> first;
  for (const uint32_t i : source) {
    gathered.triangle.push_back(state_.embedding.triangle[i]);
    gathered.barycentric.push_back(state_.embedding.barycentric[i]);
    first.push_back(state_.first_triangle[i]);
  }
  state_.embedding = std::move(gathered);
  state_.first_triangle = std::move(first);
}

// On the canonical mesh.
std::array<float, 3> AvatarSubject::Center(const Gaussians& gaussians, size_t i) const {
  const math::Vec3<float> p = math::CanonicalPlace(surface_.CanonicalArrays(),
                                                   state_.embedding.triangle[i],
                                                   state_.embedding.barycentric[i].data(),
                                                   gaussians.at(kPosition, i));
  return {p.x, p.y, p.z};
}

void AvatarSubject::Move(Gaussians& gaussians, uint32_t i, const std::array<float, 3>& offset) {
  math::FaceSearch search;
  math::MoveOnMesh(surface_.CanonicalArrays(),
                   {offset[0], offset[1], offset[2]},
                   settings_.system != AvatarSystem::kCosplat,
                   {&state_.embedding.triangle[i],
                    state_.embedding.barycentric[i].data(),
                    gaussians.at(kPosition, i)},
                   search);
}

// Those of `removed` (ascending) after whose removal their triangle has none.
std::vector<uint32_t> AvatarSubject::LastOfTheirTriangle(
    const std::vector<uint32_t>& removed) const {
  std::vector<int> left(mesh_.faces.size(), 0);
  for (const int32_t t : state_.embedding.triangle) ++left[t];
  for (const uint32_t i : removed) --left[state_.embedding.triangle[i]];
  std::vector<uint32_t> last;
  for (const uint32_t i : removed)
    if (left[state_.embedding.triangle[i]] == 0) last.push_back(i);
  return last;
}

// Renders the silhouette's alpha without what is to be removed; where that opens a hole, the last
// Gaussians of their triangles around it stay.
void AvatarSubject::Veto(const Gaussians& gaussians, std::vector<uint32_t>& removed) {
  if (settings_.system != AvatarSystem::kCosplat) return;
  const std::vector<uint32_t> last = LastOfTheirTriangle(removed);
  if (last.empty()) return;
  Gaussians thinned = gaussians;
  for (const uint32_t i : removed) thinned.at(kOpacityLogit, i)[0] = math::kGoneLogit;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape(), thin_tape = rasterizer->MakeTape();
  RenderedImage before, after;
  std::vector<uint8_t> stays(gaussians.size(), 0), holes;
  for (size_t k = 0; k < std::min(math::kHoleFrames, frames_.size()); ++k) {
    const size_t f = math::HoleFrame(k, frames_.size());
    const Camera& camera = frames_[f].camera;
    PoseFrame(f);
    Bind(gaussians, state_.embedding, surface_, posed_);
    const auto draw = [&](const Gaussians& g, RenderedImage& image, RenderTape& into) {
      const RenderSettings black{{0, 0, 0}, 0};
      rasterizer->Forward(
          PosedView(g, posed_, ColorFrame::kWorld), g.basis, camera, black, image, into);
    };
    draw(gaussians, before, *tape);
    draw(thinned, after, *thin_tape);
    holes = MeshSilhouette(vertices_, mesh_.faces, camera);
    for (size_t p = 0; p < holes.size(); ++p)
      holes[p] = math::IsHole(holes[p], before.transmittance[p], after.transmittance[p]);
    const math::HoleMask mask{holes.data(), camera.width, camera.height};
    const auto pinhole = math::ToPinhole<float>(ViewOfCamera(camera, gaussians.basis, 0));
    for (const uint32_t i : last) {
      const float radius = tape->radii()[i];
      if (stays[i] || !(radius > 0)) continue;
      const float* p = &posed_.position[3 * size_t(i)];
      const math::Vec2<float> center =
          math::ProjectPoint(pinhole, math::ToCamera(pinhole, {p[0], p[1], p[2]}));
      stays[i] = mask.HasWithin(center.x, center.y, radius);
    }
  }
  removed.erase(
      std::remove_if(removed.begin(), removed.end(), [&](uint32_t i) { return stays[i] != 0; }),
      removed.end());
}

}  // namespace cosplat

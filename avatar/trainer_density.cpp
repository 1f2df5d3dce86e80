// Density control of an avatar: what splits is re-embedded, and what goes may not tear a hole.
#include <algorithm>
#include <cmath>

#include "avatar/player.h"
#include "avatar/sample.h"
#include "avatar/silhouette.h"
#include "avatar/trainer.h"

namespace cosplat {
namespace {

// A triangle's last Gaussian goes only while the alpha inside the silhouette stays above this.
constexpr float kHoleAlpha = 0.9f;
// A loss of alpha that counts: one grey level.
constexpr float kAlphaLoss = 1.0f / 255;
// Training frames, evenly spread, in which holes are looked for.
constexpr size_t kHoleFrames = 3;

math::Vec3<float> CanonicalPosition(const Surface& surface,
                                    const Embedding& embedding,
                                    const Gaussians& gaussians,
                                    size_t i) {
  const auto& face = surface.faces()[embedding.triangle[i]];
  math::Three<SurfaceVertex> corners;
  math::Three<float> area;
  for (int c = 0; c < 3; ++c) {
    corners[c] = surface.canonical()[face[c]];
    area[c] = corners[c].area;
  }
  const float* p = gaussians.at(kPosition, i);
  math::LocalGaussian<float> local{};
  local.base_u = embedding.barycentric[i][0];
  local.base_v = embedding.barycentric[i][1];
  local.offset = {p[0], p[1], p[2]};
  local.rotation = {1, 0, 0, 0};
  return math::Embed(corners, area, local).position;
}

}  // namespace

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
  const math::Vec3<float> p = CanonicalPosition(surface_, state_.embedding, gaussians, i);
  return {p.x, p.y, p.z};
}

void AvatarSubject::Move(Gaussians& gaussians, uint32_t i, const std::array<float, 3>& offset) {
  const math::Vec3<float> p = CanonicalPosition(surface_, state_.embedding, gaussians, i);
  const EmbeddedPoint e = Reembed(
      surface_, {p.x + offset[0], p.y + offset[1], p.z + offset[2]}, state_.embedding.triangle[i]);
  state_.embedding.triangle[i] = e.base.triangle;
  state_.embedding.barycentric[i] = e.base.barycentric;
  gaussians.at(kPosition, i)[0] = gaussians.at(kPosition, i)[1] = 0;
  if (settings_.system == AvatarSystem::kCosplat) gaussians.at(kPosition, i)[2] = e.d;
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
  for (const uint32_t i : removed) thinned.at(kOpacityLogit, i)[0] = -100;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape(), thin_tape = rasterizer->MakeTape();
  RenderedImage before, after;
  std::vector<uint8_t> stays(gaussians.size(), 0);
  for (size_t k = 0; k < std::min(kHoleFrames, frames_.size()); ++k) {
    const size_t f = k * frames_.size() / kHoleFrames;
    const Camera& camera = frames_[f].camera;
    PoseFrame(f);
    Bind(gaussians, state_.embedding, surface_, posed_);
    rasterizer->Forward(PosedView(gaussians, posed_, ColorFrame::kWorld),
                        gaussians.basis,
                        camera,
                        {{0, 0, 0}, 0},
                        before,
                        *tape);
    rasterizer->Forward(PosedView(thinned, posed_, ColorFrame::kWorld),
                        gaussians.basis,
                        camera,
                        {{0, 0, 0}, 0},
                        after,
                        *thin_tape);
    const std::vector<uint8_t> inside = MeshSilhouette(vertices_, mesh_.faces, camera);
    std::vector<std::array<float, 2>> holes;
    for (size_t p = 0; p < inside.size(); ++p)
      // Also where it was below already (after an opacity reset): it shall not fall further.
      if (inside[p] && 1 - after.transmittance[p] < kHoleAlpha &&
          after.transmittance[p] - before.transmittance[p] > kAlphaLoss)
        holes.push_back({p % camera.width + 0.5f, p / camera.width + 0.5f});
    for (const uint32_t i : last) {
      const float radius = tape->radii()[i];
      if (stays[i] || !(radius > 0)) continue;
      const float* p = &posed_.position[3 * size_t(i)];
      float q[3];
      for (int r = 0; r < 3; ++r)
        q[r] = camera.rotation[3 * r] * p[0] + camera.rotation[3 * r + 1] * p[1] +
               camera.rotation[3 * r + 2] * p[2] + camera.translation[r];
      const float x = camera.fx * q[0] / q[2] + camera.cx, y = camera.fy * q[1] / q[2] + camera.cy;
      stays[i] = std::any_of(holes.begin(), holes.end(), [&](const std::array<float, 2>& h) {
        return std::hypot(h[0] - x, h[1] - y) <= radius;
      });
    }
  }
  removed.erase(
      std::remove_if(removed.begin(), removed.end(), [&](uint32_t i) { return stays[i] != 0; }),
      removed.end());
}

}  // namespace cosplat

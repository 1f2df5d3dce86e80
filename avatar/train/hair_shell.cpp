#include "avatar/train/hair_shell.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "avatar/math/one_euro.h"
#include "avatar/train/nearby.h"
#include "splat/base/median.h"

namespace cosplat {
namespace {

using math::Vec3;

// Vertices whose normals are so nearly across the line of sight are at the outline (cosine).
constexpr float kAtOutline = 0.2f;
// Metres, for a scale of 1.
constexpr float kMarch = 0.001f, kHighest = 0.05f, kFarBehind = 0.02f;
// In units of HeadRegions: the kernel of the mean, how far from the scalp's rim hair has its full
// height, and over which distance from what was measured it falls to 1 / e.
constexpr float kShellKernel = 0.15f, kFullHeight = 0.7f, kFalloff = 1.5f;

// By how much the person reaches farther than the mesh along the normal at a vertex, metres;
// negative: the frame does not show it.
class Outline {
 public:
  Outline(const MeshInFrame& seen, const Faces& faces, float scale)
      : seen_(seen),
        camera_(seen.frame->camera),
        scale_(scale),
        mesh_(DrawMesh(seen.vertices, faces, camera_)),
        normals_(NormalsOf(seen.vertices, faces)) {}

  float HeightAt(size_t v) const {
    const Vec3<float> p = seen_.Vertex(v);
    const ImagePoint at = Project(camera_, p);
    if (std::abs(Facing(camera_, p, normals_[v])) > kAtOutline || !IsIn(camera_, at)) return -1;
    const MeshPixel& shown = mesh_[PixelOf(camera_, at)];
    if (shown.face >= 0 && shown.depth < at.depth - kFarBehind * scale_) return -1;
    const float person = End(v, [&](size_t pixel) { return seen_.Alpha(pixel) >= 128; });
    const float mesh = End(v, [&](size_t pixel) { return mesh_[pixel].face >= 0; });
    if (person < 0 || mesh < 0 || mesh > kHighest * scale_) return -1;
    return std::max(0.0f, person - mesh);
  }

 private:
  // How far along the normal `covers` holds; negative: beyond the image's border.
  template <class Covers>
  float End(size_t v, const Covers& covers) const {
    float height = 0;
    for (; height <= kHighest * scale_; height += kMarch * scale_) {
      const ImagePoint at =
          Project(camera_, seen_.Vertex(v) + normals_[v] * (height + kMarch * scale_));
      if (!IsIn(camera_, at)) return -1;
      if (!covers(PixelOf(camera_, at))) break;
    }
    return height;
  }

  const MeshInFrame& seen_;
  const Camera& camera_;
  float scale_;
  std::vector<MeshPixel> mesh_;
  std::vector<Vec3<float>> normals_;
};

}  // namespace

std::vector<float> FindHairShell(const std::vector<MeshInFrame>& frames,
                                 const Faces& faces,
                                 const HeadRegions& regions,
                                 float scale) {
  const size_t count = regions.rest.size();
  std::vector<std::vector<float>> measured(count);
  for (const MeshInFrame& seen : frames) {
    const Outline outline(seen, faces, scale);
    for (size_t v = 0; v < count; ++v) {
      if (regions.within_scalp[v] <= 0) continue;
      const float height = outline.HeightAt(v);
      if (height >= 0) measured[v].push_back(height);
    }
  }
  std::vector<size_t> known;
  std::vector<float> heights(count, 0), shell(count, 0);
  for (size_t v = 0; v < count; ++v) {
    if (measured[v].empty()) continue;
    heights[v] = Median(measured[v]);
    known.push_back(v);
  }
  if (known.empty()) return shell;
  tbb::parallel_for(size_t(0), count, [&](size_t v) {
    if (regions.within_scalp[v] <= 0) return;
    float nearest = std::numeric_limits<float>::infinity();
    const float mean = Nearby(known, heights, kShellKernel * regions.unit, [&](size_t k) {
      const Vec3<float> d = regions.rest[k] - regions.rest[v];
      const float distance = std::sqrt(math::Dot(d, d));
      nearest = std::min(nearest, distance);
      return distance;
    });
    shell[v] = mean * math::Ease(regions.within_scalp[v] / kFullHeight) *
               std::exp(-nearest / (kFalloff * regions.unit));
  });
  return shell;
}

}  // namespace cosplat

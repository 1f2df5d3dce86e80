#include "avatar/surface/walk.h"

#include <string>

#include "avatar/surface/kernels/walk.h"
#include "avatar/surface/parallel_for.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

WalkResult ResultOf(const math::WalkEnd& end) { return {{end.face, {end.u, end.v}}, end.status}; }

std::vector<WalkResult> WalkEach(const Gaussians& gaussians,
                                 const Embedding& embedding,
                                 const Surface& surface) {
  std::vector<WalkResult> results(gaussians.size());
  const MeshArrays mesh = surface.CanonicalArrays();
  const float* offsets = gaussians.values[kPosition].data();
  ParallelFor(results.size(), [&](size_t i) {
    results[i] = ResultOf(math::WalkGaussian(
        mesh, embedding.triangle[i], embedding.barycentric[i].data(), offsets + 3 * i));
  });
  return results;
}

}  // namespace

WalkResult Walk(const Surface& surface, const SurfacePoint& start, float du, float dv) {
  return ResultOf(math::WalkFrom(surface.CanonicalArrays(),
                                 start.triangle,
                                 start.barycentric[0],
                                 start.barycentric[1],
                                 du,
                                 dv));
}

WalkReport WalkAll(Gaussians& gaussians,
                   Embedding& embedding,
                   const Surface& surface,
                   int boundary_face_cap) {
  std::vector<int32_t> count(surface.faces().size());
  for (size_t i = 0; i < gaussians.size(); ++i) {
    if (size_t(embedding.triangle[i]) >= count.size())
      throw Error("avatar",
                  "triangle[" + std::to_string(i) + "]",
                  std::to_string(embedding.triangle[i]) + " of " + std::to_string(count.size()));
    ++count[embedding.triangle[i]];
  }
  const std::vector<WalkResult> results = WalkEach(gaussians, embedding, surface);
  const math::WalkTaker taker{surface.CanonicalArrays(), boundary_face_cap, count.data()};
  WalkReport report;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    float* offset = &gaussians.values[kPosition][3 * i];
    offset[0] = offset[1] = 0;
    const auto& [point, status] = results[i];
    const bool invalid = status == WalkStatus::kInvalid;
    const bool crossed = point.triangle != embedding.triangle[i];
    const bool refused = !invalid && !taker.Take(embedding.triangle[i], point.triangle);
    if (invalid) report.invalid.push_back(uint32_t(i));
    if (status == WalkStatus::kBoundary || refused)
      report.stopped_at_boundary.push_back(uint32_t(i));
    if (invalid || refused) continue;
    if (crossed) report.crossed.push_back(uint32_t(i));
    embedding.triangle[i] = point.triangle;
    embedding.barycentric[i] = point.barycentric;
  }
  return report;
}

}  // namespace cosplat

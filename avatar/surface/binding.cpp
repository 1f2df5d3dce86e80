#include "avatar/surface/binding.h"

#include <algorithm>
#include <memory>
#include <string>

#include "avatar/surface/embed_packs.h"
#include "avatar/surface/kernels/embed.h"
#include "avatar/surface/parallel_for.h"
#include "avatar/surface/released_binding.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

void CheckSize(const char* field, size_t found, size_t expected) {
  if (found != expected)
    throw Error(
        "avatar",
        field,
        std::to_string(found) + " numbers where " + std::to_string(expected) + " are expected");
}

EmbedJob JobOf(const Gaussians& gaussians, const Embedding& embedding, const Surface& surface) {
  EmbedJob job;
  job.count = gaussians.size();
  if (job.count == 0) return job;
  job.triangle = embedding.triangle.data();
  job.barycentric = embedding.barycentric.data()->data();
  job.offset = gaussians.values[kPosition].data();
  job.rotation = gaussians.values[kRotation].data();
  job.scale_log = gaussians.values[kScaleLog].data();
  job.faces = surface.faces().data()->data();
  job.vertices = &surface.vertices().data()->position.x;
  job.canonical_areas = surface.canonical_areas().data();
  return job;
}

// Gaussians of each face, ascending: index[begin[f] .. begin[f + 1]).
struct FaceLists {
  std::vector<uint32_t> begin;
  std::vector<uint32_t> index;
};

FaceLists GroupByFace(const std::vector<int32_t>& triangle, size_t face_count) {
  FaceLists lists;
  lists.begin.assign(face_count + 1, 0);
  lists.index.resize(triangle.size());
  for (int32_t f : triangle) ++lists.begin[f + 1];
  for (size_t f = 0; f < face_count; ++f) lists.begin[f + 1] += lists.begin[f];
  std::vector<uint32_t> next(lists.begin.begin(), lists.begin.end() - 1);
  for (size_t i = 0; i < triangle.size(); ++i) lists.index[next[triangle[i]]++] = uint32_t(i);
  return lists;
}

}  // namespace

void CheckEmbedding(const Gaussians& gaussians, const Embedding& embedding, size_t face_count) {
  const size_t n = gaussians.size();
  const auto& values = gaussians.values;
  CheckSize("position", values[kPosition].size(), 3 * n);
  CheckSize("rotation", values[kRotation].size(), 4 * n);
  CheckSize("scale_log", values[kScaleLog].size(), 3 * n);
  CheckSize("triangle", embedding.triangle.size(), n);
  CheckSize("barycentric", embedding.barycentric.size(), n);
  // The largest of all, without a branch for each: negative numbers become large ones.
  uint32_t largest = 0;
  for (const int32_t f : embedding.triangle) largest = std::max(largest, uint32_t(f));
  if (largest < face_count || n == 0) return;
  for (size_t i = 0; i < n; ++i)
    if (uint32_t(embedding.triangle[i]) >= face_count)
      throw Error("avatar",
                  "triangle[" + std::to_string(i) + "]",
                  std::to_string(embedding.triangle[i]) + " of " + std::to_string(face_count));
}

void PosedGaussians::Resize(size_t n) {
  position.resize(3 * n);
  rotation.resize(4 * n);
  scale_log.resize(3 * n);
  frame.resize(4 * n);
}

void Bind(const Gaussians& gaussians,
          const Embedding& embedding,
          const Surface& surface,
          PosedGaussians& out) {
  CheckEmbedding(gaussians, embedding, surface.faces().size());
  out.Resize(gaussians.size());
  if (embedding.released) return BindReleased(gaussians, embedding, surface, out);
  LaunchEmbed(JobOf(gaussians, embedding, surface),
              {out.position.data(), out.rotation.data(), out.scale_log.data(), out.frame.data()});
}

void BindBackward(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  const PosedGaussians& d_posed,
                  Gaussians& d_gaussians,
                  std::vector<float>* d_vertices) {
  CheckEmbedding(gaussians, embedding, surface.faces().size());
  const size_t n = gaussians.size();
  CheckSize("d_position", d_posed.position.size(), 3 * n);
  CheckSize("d_rotation", d_posed.rotation.size(), 4 * n);
  CheckSize("d_scale_log", d_posed.scale_log.size(), 3 * n);
  if (!d_posed.frame.empty()) CheckSize("d_frame", d_posed.frame.size(), 4 * n);
  d_gaussians.values[kPosition].resize(3 * n);
  d_gaussians.values[kRotation].resize(4 * n);
  d_gaussians.values[kScaleLog].resize(3 * n);
  if (embedding.released) {
    if (d_vertices)
      throw Error("avatar", "mesh", "has no gradient by the rule of the released SplattingAvatar");
    return BindReleasedBackward(gaussians, embedding, surface, d_posed, d_gaussians);
  }
  // Of each Gaussian's triangle. Every number is written: clearing them first would take as long as
  // using them.
  const auto d_corners =
      std::make_unique_for_overwrite<float[]>(d_vertices ? 3 * kSurfaceVertexFloats * n : 0);
  LaunchEmbedVjp(JobOf(gaussians, embedding, surface),
                 {d_posed.position.data(),
                  d_posed.rotation.data(),
                  d_posed.scale_log.data(),
                  d_posed.frame.empty() ? nullptr : d_posed.frame.data()},
                 {d_gaussians.values[kPosition].data(),
                  d_gaussians.values[kRotation].data(),
                  d_gaussians.values[kScaleLog].data(),
                  d_vertices ? d_corners.get() : nullptr});
  if (!d_vertices) return;
  const FaceLists lists = GroupByFace(embedding.triangle, surface.faces().size());
  Buffer<SurfaceVertex> d_surface(surface.vertex_count());
  const math::SumAtVertexKernel sum{surface.Arrays(),
                                    {lists.begin.data(), lists.index.data()},
                                    d_corners.get(),
                                    &d_surface.data()->position.x};
  ParallelFor(d_surface.size(), [&](size_t v) { sum.Run(v); });
  surface.Backward(d_surface, *d_vertices);
}

}  // namespace cosplat

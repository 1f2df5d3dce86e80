#include "avatar/train/embedded_gaussians.h"

#include <algorithm>
#include <cmath>

#include "avatar/surface/kernels/place.h"
#include "splat/device/for_each.h"
#include "splat/device/gather.h"

namespace cosplat {
namespace {

// Concurrent searches over the mesh, each with 12 kB. One round of density control on a head
// creates some hundred children.
constexpr size_t kHostSearchers = 64, kDeviceSearchers = 1024;

}  // namespace

EmbeddedGaussians::EmbeddedGaussians(const Embedding& embedding,
                                     const Buffer<int32_t>& first_triangle,
                                     const std::vector<float>& face_rates,
                                     Stream& stream)
    : stream_(&stream) {
  if (stream.on_host())
    embedding_ = embedding;
  else
    UploadEmbedding(embedding, embedding_, stream);
  first_triangle_.Upload(first_triangle, stream);
  face_rates_.Upload(face_rates, stream);
  // Allocated now, because later, when children have to be placed, memory may be exhausted.
  searches_.Refill(stream.on_host() ? kHostSearchers : kDeviceSearchers, stream);
  stream.Wait();
}

void EmbeddedGaussians::TrianglesChanged() {
  rates_known_ = false;
  scratch_.by_face.Forget();
}

View<const float> EmbeddedGaussians::RateScale() {
  if (!std::exchange(rates_known_, true)) {
    const size_t n = embedding_.triangle.size();
    rate_scale_.Refill(3 * n, *stream_);
    ForEach(n,
            *stream_,
            RateEach{
                std::as_const(face_rates_).view(), embedding_.triangle.data(), rate_scale_.view()});
  }
  return std::as_const(rate_scale_).view();
}

Embedding EmbeddedGaussians::EmbeddingOnHost() const {
  Embedding copy;
  copy.released = embedding_.released;
  copy.triangle = Buffer<int32_t>(embedding_.triangle.Downloaded(*stream_));
  copy.barycentric = Buffer<std::array<float, 2>>(embedding_.barycentric.Downloaded(*stream_));
  return copy;
}

void EmbeddedGaussians::Walk(const Surface& surface, Gaussians& gaussians, AdamState& adam) {
  walk_.Run(surface, kBoundaryFaceCap, scratch_.by_face, embedding_, gaussians.values[kPosition]);
  for (Gaussians* moments : {&adam.m, &adam.v})
    walk_.ResetMoment(moments->values[kPosition], *stream_);
  TrianglesChanged();
}

void EmbeddedGaussians::Gather(View<const uint32_t> source) {
  GatherRows(embedding_.triangle, spare_triangle_, 1, source, source.count, *stream_);
  GatherRows(embedding_.barycentric, spare_barycentric_, 1, source, source.count, *stream_);
  GatherRows(first_triangle_, spare_triangle_, 1, source, source.count, *stream_);
  TrianglesChanged();
}

View<const float> EmbeddedGaussians::Centers(const Surface& surface, const Gaussians& gaussians) {
  centers_.Refill(3 * gaussians.size(), *stream_);
  ForEach(gaussians.size(),
          *stream_,
          PlaceEach{surface.CanonicalArrays(),
                    embedding_.triangle.data(),
                    embedding_.barycentric_data(),
                    gaussians.values[kPosition].view(),
                    centers_.view()});
  return std::as_const(centers_).view();
}

void EmbeddedGaussians::Move(const Surface& surface,
                             bool released,
                             View<const float> offsets,
                             size_t first,
                             Gaussians& gaussians) {
  ForEach(std::min(searches_.size(), offsets.count / 3),
          *stream_,
          MoveEach{surface.CanonicalArrays(),
                   offsets,
                   first,
                   released,
                   searches_.view(),
                   embedding_.triangle.data(),
                   embedding_.barycentric_data(),
                   gaussians.values[kPosition].view()});
  TrianglesChanged();
}

size_t EmbeddedGaussians::allocated_bytes() const {
  return AllocatedBytes(embedding_.triangle, embedding_.barycentric, spare_triangle_) +
         AllocatedBytes(spare_barycentric_, first_triangle_, rate_scale_, centers_) +
         AllocatedBytes(scratch_.d_corners, scratch_.d_log_light) +
         scratch_.by_face.allocated_bytes() + walk_.allocated_bytes();
}

size_t EmbeddedGaussians::MeshBytes() const {
  return scratch_.by_face.MeshBytes() + walk_.MeshBytes() +
         AllocatedBytes(scratch_.d_surface, searches_, face_rates_);
}

}  // namespace cosplat

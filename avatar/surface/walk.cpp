#include "avatar/surface/walk.h"

#include <string>

#include "splat/base/error.h"
#include "splat/device/for_each.h"

namespace cosplat {

WalkResult Walk(const Surface& surface, const SurfacePoint& start, float du, float dv) {
  const math::WalkEnd end = math::WalkFrom(surface.CanonicalArrays(),
                                           start.triangle,
                                           start.barycentric[0],
                                           start.barycentric[1],
                                           du,
                                           dv);
  return {{end.face, {end.u, end.v}}, end.status};
}

void TriangleWalk::Run(const Surface& surface,
                       int boundary_face_cap,
                       FaceLists& by_face,
                       Embedding& embedding,
                       Buffer<float>& position) {
  Stream& stream = surface.stream();
  const size_t n = embedding.triangle.size();
  float* barycentric = embedding.barycentric_data();
  ends_.Refill(n, stream);
  taken_.Refill(n, stream);
  outcomes_.Refill(n, stream);
  places_.Refill(n + 1, stream);
  ForEach(n + 1,
          stream,
          WalkOne{surface.CanonicalArrays(),
                  embedding.triangle.data(),
                  barycentric,
                  std::as_const(position).view(),
                  ends_.view(),
                  taken_.view(),
                  places_.view()});
  TakeInTurn(surface, boundary_face_cap, by_face, embedding);
  ForEach(n,
          stream,
          SettleWalk{std::as_const(ends_).view(),
                     std::as_const(taken_).view(),
                     embedding.triangle.data(),
                     barycentric,
                     position.view(),
                     outcomes_.view()});
  by_face.Forget();
}

void TriangleWalk::TakeInTurn(const Surface& surface,
                              int boundary_face_cap,
                              FaceLists& by_face,
                              const Embedding& embedding) {
  Stream& stream = surface.stream();
  const size_t n = embedding.triangle.size(), faces = surface.faces().size();
  stream.ExclusiveSum(places_);
  at_boundary_.Refill(n, stream);
  ForEach(n, stream, ListTouching{std::as_const(places_).view(), at_boundary_.view()});
  face_count_.Refill(faces, stream);
  ForEach(
      faces, stream, CountOnFace{by_face.Of(embedding, faces, stream).begin, face_count_.view()});
  ForEach(1,
          stream,
          TakeEach{{surface.CanonicalArrays(), boundary_face_cap, face_count_.data()},
                   embedding.triangle.data(),
                   std::as_const(at_boundary_).view(),
                   places_.data() + n,
                   std::as_const(ends_).view(),
                   taken_.view()});
}

void TriangleWalk::ResetMoment(Buffer<float>& moment, Stream& stream) const {
  ForEach(outcomes_.size(), stream, ForgetMoment{outcomes_.view(), moment.view()});
}

WalkReport WalkAll(Gaussians& gaussians,
                   Embedding& embedding,
                   const Surface& surface,
                   int boundary_face_cap) {
  CheckEmbedding(gaussians, embedding, surface.faces().size());
  FaceLists by_face;
  TriangleWalk walk;
  walk.Run(surface, boundary_face_cap, by_face, embedding, gaussians.values[kPosition]);
  WalkReport report;
  for (uint32_t i = 0; i < walk.outcomes().size(); ++i) {
    const uint8_t outcome = walk.outcomes()[i];
    if (outcome & kWalkCrossed) report.crossed.push_back(i);
    if (outcome & kWalkStopped) report.stopped_at_boundary.push_back(i);
    if (outcome & kWalkInvalid) report.invalid.push_back(i);
  }
  return report;
}

}  // namespace cosplat

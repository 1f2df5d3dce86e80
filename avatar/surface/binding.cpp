#include "avatar/surface/binding.h"

#include <algorithm>
#include <bit>
#include <string>

#include "avatar/surface/kernels/embed.h"
#include "splat/base/error.h"
#include "splat/basis_constants.h"
#include "splat/device/for_each.h"
#include "splat/device/gather.h"
#include "splat/device/sum_tree.h"

namespace cosplat {
namespace {

void CheckSize(const char* field, size_t found, size_t expected) {
  if (found != expected)
    throw Error(
        "avatar",
        field,
        std::to_string(found) + " numbers where " + std::to_string(expected) + " are expected");
}

// Throws Error if the avatar has a part that only avatar/math/embed.h's rule knows, and another
// one.
void RequireOurs(const Embedding& embedding, const char* part) {
  if (embedding.rigid) throw Error("avatar", part, "not supported with GaussianAvatars' rule");
  if (embedding.released)
    throw Error("avatar", part, "not supported with the rule of SplattingAvatar's released code");
}

EmbeddedArrays ArraysOf(const Gaussians& gaussians,
                        const Embedding& embedding,
                        const Surface& surface,
                        const Appearance& appearance) {
  EmbeddedArrays arrays;
  arrays.count = gaussians.size();
  if (arrays.count == 0) return arrays;
  const SurfaceArrays posed = surface.Arrays();
  arrays.triangle = embedding.triangle.data();
  arrays.barycentric = embedding.barycentric_data();
  arrays.offset = gaussians.values[kPosition].data();
  arrays.rotation = gaussians.values[kRotation].data();
  arrays.scale_log = gaussians.values[kScaleLog].data();
  arrays.faces = posed.faces;
  arrays.vertices = posed.vertices;
  arrays.canonical_areas = surface.canonical_areas().data();
  arrays.opacity_logit = gaussians.values[kOpacityLogit].data();
  arrays.color_dc = gaussians.values[kColorDc].data();
  static_assert(math::kCorrectionWidth == kCorrectionNumbers);
  if (gaussians.corrections > 0)
    arrays.corrections = {size_t(gaussians.corrections),
                          gaussians.values[kCorrection].data(),
                          appearance.weights.data};
  if (!appearance.light.empty())
    arrays.light = {appearance.light.data,
                    appearance.light_mean.empty() ? nullptr : appearance.light_mean.data,
                    -0.5f / BasisConstants(gaussians.basis)[0]};
  return arrays;
}

}  // namespace

void CheckEmbedding(const Gaussians& gaussians, const Embedding& embedding, size_t face_count) {
  const size_t n = gaussians.size();
  const auto& values = gaussians.values;
  CheckSize("position", values[kPosition].size(), 3 * n);
  CheckSize("rotation", values[kRotation].size(), 4 * n);
  CheckSize("scale_log", values[kScaleLog].size(), 3 * n);
  CheckSize("corrections", values[kCorrection].size(), n * gaussians.width(kCorrection));
  CheckSize("triangle", embedding.triangle.size(), n);
  CheckSize("barycentric", embedding.barycentric.size(), n);
  if (gaussians.corrections > 0) RequireOurs(embedding, "corrections");
  // One maximum instead of a branch per triangle; negative numbers become large unsigned ones.
  uint32_t largest = 0;
  for (const int32_t f : embedding.triangle) largest = std::max(largest, uint32_t(f));
  if (largest < face_count || n == 0) return;
  for (size_t i = 0; i < n; ++i)
    if (uint32_t(embedding.triangle[i]) >= face_count)
      throw Error("avatar",
                  "triangle[" + std::to_string(i) + "]",
                  std::to_string(embedding.triangle[i]) + " of " + std::to_string(face_count));
}

void PosedGaussians::Refill(size_t n, Stream& stream) {
  position.Refill(3 * n, stream);
  rotation.Refill(4 * n, stream);
  scale_log.Refill(3 * n, stream);
  frame.Refill(4 * n, stream);
}

WorldGaussians PosedView(const Gaussians& gaussians,
                         const PosedGaussians& posed,
                         ColorFrame color_frame) {
  WorldGaussians view = ViewOf(gaussians);
  view.position = posed.position.data();
  view.rotation = posed.rotation.data();
  view.scale_log = posed.scale_log.data();
  if (color_frame == ColorFrame::kSurface) view.color_frame = posed.frame.data();
  if (gaussians.corrections > 0) {
    view.opacity_logit = posed.opacity_logit.data();
  }
  if (!posed.color_dc.empty()) view.color_dc = posed.color_dc.data();
  return view;
}

void UploadEmbedding(const Embedding& from, Embedding& to, Stream& stream) {
  if (from.released)
    throw Error("avatar",
                "mesh",
                "uses the rule of SplattingAvatar's released code, which only the CPU supports");
  to.triangle.Upload(from.triangle, stream);
  to.barycentric.Upload(from.barycentric, stream);
  to.rigid = from.rigid;
}

FaceListArrays FaceLists::Of(const Embedding& embedding, size_t face_count, Stream& stream) {
  if (!known_) {
    const size_t n = embedding.triangle.size();
    by_face_.Refill(n, stream);
    begin_.Refill(face_count + 1, stream);
    ForEach(n,
            stream,
            FaceKeys{embedding.triangle.data(), by_face_.keys.view(), by_face_.values.view()});
    stream.Sort(by_face_, std::bit_width(face_count));
    ForEach(face_count + 1, stream, FindBegin{std::as_const(by_face_.keys).view(), begin_.view()});
    known_ = true;
  }
  return {begin_.data(), by_face_.values.data()};
}

void Bind(const Gaussians& gaussians,
          const Embedding& embedding,
          const Surface& surface,
          PosedGaussians& out,
          const Appearance& appearance) {
  Stream& stream = surface.stream();
  if (stream.on_host()) CheckEmbedding(gaussians, embedding, surface.faces().size());
  CheckSize("weights", appearance.weights.size(), size_t(gaussians.corrections));
  const bool lit = !appearance.light.empty();
  if (lit) {
    RequireOurs(embedding, "light");
    CheckSize("light", appearance.light.size(), kLightNumbers);
  }
  if (!appearance.light_mean.empty())
    CheckSize("light_mean",
              appearance.light_mean.size(),
              surface.vertex_count() * size_t(math::kLightTerms));
  out.Refill(gaussians.size(), stream);
  out.opacity_logit.Refill(gaussians.corrections > 0 ? gaussians.size() : 0, stream);
  out.color_dc.Refill(gaussians.corrections > 0 || lit ? 3 * gaussians.size() : 0, stream);
  if (embedding.released) return BindReleased(gaussians, embedding, surface, out);
  const EmbeddedArrays arrays = ArraysOf(gaussians, embedding, surface, appearance);
  const PosedArrays<float> posed{out.position.data(),
                                 out.rotation.data(),
                                 out.scale_log.data(),
                                 out.frame.data(),
                                 out.opacity_logit.data(),
                                 out.color_dc.data()};
  if (embedding.rigid)
    return ForEachRow(
        arrays.count, stream, RigidEmbedKernel{arrays, surface.Arrays().posed_faces, posed});
  ForEachRow(arrays.count, stream, EmbedKernel{arrays, posed});
}

void BindBackward(const Gaussians& gaussians,
                  const Embedding& embedding,
                  Surface& surface,
                  const PosedGaussians& d_posed,
                  Gaussians& d_gaussians,
                  Buffer<float>* d_vertices,
                  BindScratch& scratch,
                  const Appearance& appearance,
                  Buffer<float>* d_light) {
  Stream& stream = surface.stream();
  if (stream.on_host()) CheckEmbedding(gaussians, embedding, surface.faces().size());
  if (embedding.rigid) throw Error("avatar", "mesh", "has no gradient under GaussianAvatars' rule");
  const size_t n = gaussians.size();
  CheckSize("d_position", d_posed.position.size(), 3 * n);
  CheckSize("d_rotation", d_posed.rotation.size(), 4 * n);
  CheckSize("d_scale_log", d_posed.scale_log.size(), 3 * n);
  if (!d_posed.frame.empty()) CheckSize("d_frame", d_posed.frame.size(), 4 * n);
  auto& d = d_gaussians.values;
  d[kPosition].Refill(3 * n, stream);
  d[kRotation].Refill(4 * n, stream);
  d[kScaleLog].Refill(3 * n, stream);
  d[kCorrection].Refill(n * gaussians.width(kCorrection), stream);
  if (embedding.released) {
    if (d_vertices)
      throw Error(
          "avatar", "mesh", "has no gradient under the rule of SplattingAvatar's released code");
    return BindReleasedBackward(gaussians, embedding, surface, d_posed, d_gaussians);
  }
  // Derivatives for the corners of each Gaussian's triangle. The kernel writes every number, so
  // they are not cleared first, which would take as long as using them.
  if (d_vertices) scratch.d_corners.Refill(3 * kSurfaceVertexFloats * n, stream);
  float* d_corners = d_vertices ? scratch.d_corners.data() : nullptr;
  const EmbeddedArrays arrays = ArraysOf(gaussians, embedding, surface, appearance);
  const bool lit = !appearance.light.empty();
  scratch.d_log_light.Refill(lit ? 3 * n : 0, stream);
  ForEachRow(n,
             stream,
             EmbedVjpKernel{arrays,
                            {d_posed.position.data(),
                             d_posed.rotation.data(),
                             d_posed.scale_log.data(),
                             d_posed.frame.empty() ? nullptr : d_posed.frame.data(),
                             d[kOpacityLogit].data(),
                             d[kColorDc].data()},
                            {d[kPosition].data(),
                             d[kRotation].data(),
                             d[kScaleLog].data(),
                             d_corners,
                             d[kCorrection].data(),
                             d[kColorDc].data(),
                             scratch.d_log_light.data()}});
  if (lit && d_light) {
    const size_t blocks = (n + SumLight::kBlock - 1) / SumLight::kBlock;
    scratch.light_sums.Refill(blocks, stream);
    d_light->Refill(kLightNumbers, stream);
    ForEach(blocks,
            stream,
            SumLight{arrays, std::as_const(scratch.d_log_light).view(), scratch.light_sums.view()});
    ForEach(
        1,
        stream,
        AddUpLight{SumInTree(std::as_const(scratch.light_sums).view(), scratch.light_tree, stream),
                   d_light->view()});
  }
  if (!d_vertices) return;
  Buffer<SurfaceVertex>& d_surface = scratch.d_surface;
  d_surface.Refill(surface.vertex_count(), stream);
  ForEach(d_surface.size(),
          stream,
          math::SumAtVertexKernel{surface.Arrays(),
                                  scratch.by_face.Of(embedding, surface.faces().size(), stream),
                                  d_corners,
                                  &d_surface.data()->position.x});
  surface.Backward(d_surface, *d_vertices);
}

}  // namespace cosplat

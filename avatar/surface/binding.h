// Embedded Gaussians -> posed Gaussians in the frame's world, and the derivative.
//
// AvatarModel + Surface (posed) -> Bind -> PosedGaussians -> rasteriser; backward: d_position, ...
// -> BindBackward -> gradients of the embedded parameters and, if requested, of the posed vertices.
// Formula: avatar/math/embed.h, or avatar/math/released_embed.h if Embedding::released is set, or
// avatar/math/rigid_embed.h if Embedding::rigid is. On the host or on a device; bit-identical for
// any number of threads.
#pragma once

#include "avatar/model/avatar_model.h"
#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/kernels/light.h"
#include "avatar/surface/surface.h"
#include "splat/device/sort.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

struct PosedGaussians {
  Buffer<float> position;       // [N, 3] metres, world of the posed mesh
  Buffer<float> rotation;       // [N, 4] wxyz, with the norm of the local rotation
  Buffer<float> scale_log;      // [N, 3] log(metres)
  Buffer<float> frame;          // [N, 4] wxyz, unit: canonical to posed at the Gaussian
  Buffer<float> opacity_logit;  // [N] with corrections (avatar/math/correct.h), else empty
  Buffer<float> color_dc;       // [N, 3] with corrections or light (avatar/math/light.h)

  size_t size() const { return position.size() / 3; }
  // Resizes all but opacities and colours; the values are undefined.
  void Refill(size_t n, Stream& stream);
  void Resize(size_t n) { Refill(n, HostStream()); }
  size_t allocated_bytes() const {  // bytes
    return AllocatedBytes(position, rotation, scale_log, frame) +
           AllocatedBytes(opacity_logit, color_dc);
  }
  static constexpr size_t kBytesPerGaussian = (3 + 4 + 3 + 4) * sizeof(float);
};

// The rasteriser's input: `gaussians` with what `posed` has in place of their own.
WorldGaussians PosedView(const Gaussians& gaussians,
                         const PosedGaussians& posed,
                         ColorFrame color_frame);

// Throws Error when an array has a wrong size, a triangle does not exist, or there are corrections
// under another rule than avatar/math/embed.h. For arrays in the host's memory.
void CheckEmbedding(const Gaussians& gaussians, const Embedding& embedding, size_t face_count);

// Copies an embedding to a device; `from` must stay unchanged until the stream has been waited for.
// Throws Error if it has the released rule, which only the CPU supports.
void UploadEmbedding(const Embedding& from, Embedding& to, Stream& stream);

// The Gaussians of each face, sorted lazily after a change.
class FaceLists {
 public:
  FaceListArrays Of(const Embedding& embedding, size_t face_count, Stream& stream);
  // To be called when the embedding has changed.
  void Forget() { known_ = false; }
  // Bytes of buffers per Gaussian, and of buffers per face.
  size_t allocated_bytes() const { return by_face_.allocated_bytes(); }
  size_t MeshBytes() const { return AllocatedBytes(begin_); }
  static constexpr size_t kBytesPerGaussian = 4 * sizeof(uint32_t);

 private:
  bool known_ = false;
  KeyedValues by_face_;
  Buffer<uint32_t> begin_;
};

// What opacities and colours depend on besides the mesh, in the memory of the surface's stream.
struct Appearance {
  View<const float> weights{};  // [gaussians.corrections] of the frame (avatar/model/corrections.h)
  View<const float> light{};    // AvatarModel::light, or empty
  // [V, kLightTerms] subtracted from the terms of the light at the vertices, or empty. In training
  // it is their mean over the frames, so that the light does not take the place of colours.
  View<const float> light_mean{};
};

// Overwrites `out`. All arrays are in the memory of the surface's stream. On the host, throws as
// CheckEmbedding does, and for a light under another rule than avatar/math/embed.h.
void Bind(const Gaussians& gaussians,
          const Embedding& embedding,
          const Surface& surface,
          PosedGaussians& out,
          const Appearance& appearance = {});
inline Appearance AppearanceOf(const AvatarModel& model, View<const float> weights) {
  return {weights, model.light ? View<const float>(*model.light) : View<const float>{}, {}};
}
// On the host.
inline void Bind(const AvatarModel& model,
                 const Surface& surface,
                 PosedGaussians& out,
                 View<const float> weights = {}) {
  Bind(model.gaussians, model.embedding, surface, out, AppearanceOf(model, weights));
}

// Scratch memory of BindBackward. Reuse it to avoid allocations.
struct BindScratch {
  FaceLists by_face;
  Buffer<float> d_corners;          // [N, 3, kSurfaceVertexFloats]
  Buffer<SurfaceVertex> d_surface;  // [V]
  Buffer<float> d_log_light;        // [N, 3]
  Buffer<LightSum> light_sums, light_tree;
  static constexpr size_t kBytesPerGaussian = 3 * kSurfaceVertexFloats * sizeof(float);
};

// d_posed: dL/d(output of Bind), in the same layout; an empty `frame` counts as zero (colours in
// the world frame). d_gaussians: kOpacityLogit and kColorDc must hold dL/d(those of Bind's output),
// so d_posed has none; with light kColorDc becomes the Gaussians' own derivative, otherwise it is
// that already. Resizes and overwrites kPosition = d(du, dv, d), kRotation, kScaleLog and
// kCorrection of d_gaussians; its other attributes are left unchanged. d_vertices: [V, 3],
// overwritten; null to skip its computation. Throws Error if it is requested for an embedding with
// the released rule, which has no derivative for it, and for a rigid one, which has none. d_light:
// [kLightTerms, 3], overwritten if there is a light; null to skip its computation.
void BindBackward(const Gaussians& gaussians,
                  const Embedding& embedding,
                  Surface& surface,
                  const PosedGaussians& d_posed,
                  Gaussians& d_gaussians,
                  Buffer<float>* d_vertices,
                  BindScratch& scratch,
                  const Appearance& appearance = {},
                  Buffer<float>* d_light = nullptr);
inline void BindBackward(const AvatarModel& model,
                         Surface& surface,
                         const PosedGaussians& d_posed,
                         Gaussians& d_gaussians,
                         Buffer<float>* d_vertices = nullptr,
                         View<const float> weights = {}) {
  BindScratch scratch;
  BindBackward(model.gaussians,
               model.embedding,
               surface,
               d_posed,
               d_gaussians,
               d_vertices,
               scratch,
               AppearanceOf(model, weights));
}

// Bind and BindBackward call these if Embedding::released is set. They follow the rule of
// SplattingAvatar's code release, including its faults, for the preset that reproduces it and for
// rendering avatars trained with it. Formula: avatar/math/released_embed.h. Not optimised: one
// Gaussian at a time. Bit-identical for any number of threads. Arrays and triangles must have been
// checked, and `out` must have its size.
void BindReleased(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  PosedGaussians& out);

// Overwrites kPosition (zero for du and dv), kRotation and kScaleLog of d_gaussians, which must
// have their sizes.
void BindReleasedBackward(const Gaussians& gaussians,
                          const Embedding& embedding,
                          const Surface& surface,
                          const PosedGaussians& d_posed,
                          Gaussians& d_gaussians);

}  // namespace cosplat

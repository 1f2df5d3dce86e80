// Embedded Gaussians -> posed Gaussians in the frame's world, and the derivative.
//
// AvatarModel + Surface (posed) -> Bind -> PosedGaussians -> rasterizer; back: d_position, ... ->
// BindBackward -> gradients of the embedded parameters and, if wanted, of the posed vertices.
// The formula is avatar/math/embed.h, or that of avatar/surface/binding.h where the
// embedding says so. On the host or on a device; bits do not depend on the number of threads.
#pragma once

#include "avatar/model/avatar_model.h"
#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/surface.h"
#include "splat/device/sort.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

struct PosedGaussians {
  Buffer<float> position;   // [N, 3] metres, world of the posed mesh
  Buffer<float> rotation;   // [N, 4] wxyz, the norm of the local rotation
  Buffer<float> scale_log;  // [N, 3] log(metres)
  Buffer<float> frame;      // [N, 4] wxyz, unit: canonical to posed at the Gaussian's place

  size_t size() const { return position.size() / 3; }
  // Any values.
  void Refill(size_t n, Stream& stream);
  void Resize(size_t n) { Refill(n, HostStream()); }
  size_t held() const { return HeldBy(position, rotation, scale_log, frame); }  // bytes
  static constexpr size_t kBytesPerGaussian = (3 + 4 + 3 + 4) * sizeof(float);
};

// `gaussians` with these numbers in place of its own: what the rasteriser takes.
WorldGaussians PosedView(const Gaussians& gaussians,
                         const PosedGaussians& posed,
                         ColorFrame color_frame);

// Throws Error when an array has a wrong size or a triangle does not exist. In the host's memory.
void CheckEmbedding(const Gaussians& gaussians, const Embedding& embedding, size_t face_count);

// A device's copy of an embedding, which must stay until the stream was waited for. Throws Error
// where it has the released rule, which the CPU alone follows.
void UploadEmbedding(const Embedding& from, Embedding& to, Stream& stream);

// The Gaussians of each face: sorted when first asked for after a change.
class FaceLists {
 public:
  FaceListArrays Of(const Embedding& embedding, size_t face_count, Stream& stream);
  // The embedding has changed.
  void Forget() { known_ = false; }
  // Bytes that grow with the Gaussians, and others.
  size_t held() const { return by_face_.held(); }
  size_t HeldForMesh() const { return HeldBy(begin_); }
  static constexpr size_t kBytesPerGaussian = 4 * sizeof(uint32_t);

 private:
  bool known_ = false;
  KeyedValues by_face_;
  Buffer<uint32_t> begin_;
};

// Writes all of `out`. Everything is in the memory of the surface's stream; on the host, throws as
// CheckEmbedding does.
void Bind(const Gaussians& gaussians,
          const Embedding& embedding,
          const Surface& surface,
          PosedGaussians& out);
inline void Bind(const AvatarModel& model, const Surface& surface, PosedGaussians& out) {
  Bind(model.gaussians, model.embedding, surface, out);
}

// What BindBackward works in for d_vertices. Reuse it: it keeps its memory.
struct BindScratch {
  FaceLists by_face;
  Buffer<float> d_corners;          // [N, 3, kSurfaceVertexFloats]
  Buffer<SurfaceVertex> d_surface;  // [V]
  static constexpr size_t kBytesPerGaussian = 3 * kSurfaceVertexFloats * sizeof(float);
};

// d_posed: dL/d(out of Bind), same layout; an empty `frame` counts as zero (colours in the world
// frame). Overwrites (and sizes) kPosition = d(du, dv, d), kRotation and kScaleLog of d_gaussians;
// leaves its other attributes alone. d_vertices: [V, 3] overwritten, or null: then its cost is
// saved. Throws Error when it is wanted of an embedding with the released rule, which has none.
void BindBackward(const Gaussians& gaussians,
                  const Embedding& embedding,
                  Surface& surface,
                  const PosedGaussians& d_posed,
                  Gaussians& d_gaussians,
                  Buffer<float>* d_vertices,
                  BindScratch& scratch);
inline void BindBackward(const AvatarModel& model,
                         Surface& surface,
                         const PosedGaussians& d_posed,
                         Gaussians& d_gaussians,
                         Buffer<float>* d_vertices = nullptr) {
  BindScratch scratch;
  BindBackward(
      model.gaussians, model.embedding, surface, d_posed, d_gaussians, d_vertices, scratch);
}

// Bind and BindBackward by SplattingAvatar's rule as its code was released, faults included, for
// the preset that reproduces it and for playing what that trained.
//
// called by avatar/surface/binding.cpp where Embedding::released is set. The formula is
// avatar/math/released_embed.h. One Gaussian at a time: nobody waits for it. Bits do not depend on
// the number of threads.

// The arrays and triangles have been checked, `out` has its size.
void BindReleased(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  PosedGaussians& out);

// Writes all of kPosition (du and dv: zero), kRotation and kScaleLog of d_gaussians, which have
// their sizes.
void BindReleasedBackward(const Gaussians& gaussians,
                          const Embedding& embedding,
                          const Surface& surface,
                          const PosedGaussians& d_posed,
                          Gaussians& d_gaussians);

}  // namespace cosplat

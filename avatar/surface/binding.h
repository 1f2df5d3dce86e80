// Embedded Gaussians -> posed Gaussians in the frame's world, and the derivative.
//
// AvatarModel + Surface (posed) -> Bind -> PosedGaussians -> rasterizer; back: d_position, ... ->
// BindBackward -> gradients of the embedded parameters and, if wanted, of the posed vertices.
// The formula is avatar/math/embed.h, or that of avatar/surface/released_binding.h where the
// embedding says so. Bits do not depend on the number of threads.
#pragma once

#include <vector>

#include "avatar/model/avatar_model.h"
#include "avatar/surface/surface.h"
#include "splat/device/buffer.h"

namespace cosplat {

struct PosedGaussians {
  Buffer<float> position;   // [N, 3] metres, world of the posed mesh
  Buffer<float> rotation;   // [N, 4] wxyz, the norm of the local rotation
  Buffer<float> scale_log;  // [N, 3] log(metres)
  Buffer<float> frame;      // [N, 4] wxyz, unit: canonical to posed at the Gaussian's place

  size_t size() const { return position.size() / 3; }
  void Resize(size_t n);
};

// Throws Error when an array has a wrong size or a triangle does not exist.
void CheckEmbedding(const Gaussians& gaussians, const Embedding& embedding, size_t face_count);

// Writes all of `out`, resizing it. Throws as CheckEmbedding does.
void Bind(const Gaussians& gaussians,
          const Embedding& embedding,
          const Surface& surface,
          PosedGaussians& out);
inline void Bind(const AvatarModel& model, const Surface& surface, PosedGaussians& out) {
  Bind(model.gaussians, model, surface, out);
}

// d_posed: dL/d(out of Bind), same layout; an empty `frame` counts as zero (colours in the world
// frame). Overwrites (and sizes) kPosition = d(du, dv, d), kRotation and kScaleLog of d_gaussians;
// leaves its other attributes alone. d_vertices: [V, 3] overwritten, or null: then its cost is
// saved. Throws Error when it is wanted of an embedding with the released rule, which has none.
void BindBackward(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  const PosedGaussians& d_posed,
                  Gaussians& d_gaussians,
                  std::vector<float>* d_vertices = nullptr);
inline void BindBackward(const AvatarModel& model,
                         const Surface& surface,
                         const PosedGaussians& d_posed,
                         Gaussians& d_gaussians,
                         std::vector<float>* d_vertices = nullptr) {
  BindBackward(model.gaussians, model, surface, d_posed, d_gaussians, d_vertices);
}

}  // namespace cosplat

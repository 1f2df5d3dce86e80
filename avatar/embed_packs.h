// The loops of avatar/binding.h over Gaussians: the formulas of avatar/math/embed.h on SIMD packs,
// compiled per instruction set and run over oneTBB. Plain arrays, and none of the formulas'
// headers: those are included once per instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "avatar/surface_packs.h"

namespace cosplat {

// Gaussians on the triangles of a posed mesh. The triangles must exist.
struct EmbedJob {
  size_t count = 0;
  const int32_t* triangle = nullptr;                  // [N]
  const std::array<float, 2>* barycentric = nullptr;  // [N]
  const float* offset = nullptr;                      // [N, 3] (du, dv, d)
  const float* rotation = nullptr;                    // [N, 4]
  const float* scale_log = nullptr;                   // [N, 3]
  const std::array<int32_t, 3>* faces = nullptr;      // [F]
  const float* vertices = nullptr;                    // [V, kSurfaceVertexFloats]
  const float* canonical_areas = nullptr;             // [F, 4] at the corners; the fourth is unused
};

// The arrays of PosedGaussians (avatar/binding.h).
template <class T>
struct PosedArrays {
  T* position = nullptr;
  T* rotation = nullptr;
  T* scale_log = nullptr;
  T* frame = nullptr;
};
void LaunchEmbed(const EmbedJob& job, const PosedArrays<float>& out);

// Derivatives, overwritten. `corners`: [N, 3, kSurfaceVertexFloats] of the triangle's vertices for
// each Gaussian, or null.
struct EmbedAdjoints {
  float* offset = nullptr;
  float* rotation = nullptr;
  float* scale_log = nullptr;
  float* corners = nullptr;
};
// d_posed.frame may be null: zero.
void LaunchEmbedVjp(const EmbedJob& job,
                    const PosedArrays<const float>& d_posed,
                    const EmbedAdjoints& out);

}  // namespace cosplat

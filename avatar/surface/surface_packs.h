// The loops of avatar/surface/surface.h over faces and vertices: avatar/surface/kernels/surface.h
// on SIMD packs, compiled per instruction set and run over oneTBB. None of the formulas' headers:
// those are included once per instruction set.
#pragma once

#include "avatar/surface/kernels/arrays.h"

namespace cosplat {

// From the vertices' positions, everything else: the posed faces, then the vertices' other numbers,
// sums and signs.
void LaunchPoseSurface(const SurfaceArrays& surface);

// d_vertices: [V, kSurfaceVertexFloats] dL/d(vertices). Overwritten: d_sums, the same size, of the
// sums over the faces; d_corners [F, 3, 3] of the faces' corners.
void LaunchPoseSurfaceVjp(const SurfaceArrays& surface,
                          const float* d_vertices,
                          float* d_sums,
                          float* d_corners);

}  // namespace cosplat

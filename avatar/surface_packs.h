// The loops of avatar/surface.h over faces and vertices: the formulas of avatar/math/frame.h on
// SIMD packs, compiled per instruction set and run over oneTBB. Plain arrays, and none of the
// formulas' headers: those are included once per instruction set.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace cosplat {

// Rows of a SurfaceVertex array: position 3, normal 3, rotation 4, area 1.
constexpr size_t kSurfaceVertexFloats = 11;
// Rows of faces: area vector 3, its length, rotation from canonical to posed 4.
constexpr size_t kPosedFaceFloats = 8;
// Rows of what vertices are normalised from: normal 3, rotation 4.
constexpr size_t kVertexSumFloats = 7;

// A mesh and one pose of it. `posed_faces` ends with a row of zeros, a face that adds nothing.
struct SurfaceArrays {
  size_t face_count = 0;
  size_t vertex_count = 0;
  const std::array<int32_t, 3>* faces = nullptr;  // [F]
  const int32_t* vertex_face_begin = nullptr;     // [V + 1]
  const int32_t* vertex_faces = nullptr;          // [3 F]
  const int32_t* corner_places = nullptr;         // [F, 3] where vertex_faces lists the corner
  const float* canonical_frames = nullptr;        // [F, 9] row-major
  float* vertices = nullptr;                      // [V, kSurfaceVertexFloats]
  float* posed_faces = nullptr;                   // [F + 1, kPosedFaceFloats]
  float* sums = nullptr;                          // [V, kVertexSumFloats]
  float* signs = nullptr;  // [3 F] like vertex_faces: hemisphere in which the rotation was added
};

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

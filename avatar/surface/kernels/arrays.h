// Arguments of the element-wise avatar kernels: borrowed arrays in host or device memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/device/buffer.h"
#include "splat/math/namespace.h"

namespace cosplat {

// Rows of a SurfaceVertex array: position 3, normal 3, rotation 4, area 1.
constexpr size_t kSurfaceVertexFloats = 11;
// Rows of faces: area vector 3, its length, rotation from canonical to posed 4.
constexpr size_t kPosedFaceFloats = 8;
// Rows of unnormalised vertex sums: normal 3, rotation 4.
constexpr size_t kVertexSumFloats = 7;

// A mesh and one pose of it. `posed_faces` ends with a row of zeros, a face that contributes
// nothing.
struct SurfaceArrays {
  size_t face_count = 0;
  size_t vertex_count = 0;
  const int32_t* faces = nullptr;              // [F, 3]
  const int32_t* vertex_face_begin = nullptr;  // [V + 1]
  const int32_t* vertex_faces = nullptr;       // [3 F]
  const int32_t* corner_places = nullptr;      // [F, 3] index of the corner in vertex_faces
  const float* canonical_frames = nullptr;     // [F, 9] row-major
  float* vertices = nullptr;                   // [V, kSurfaceVertexFloats]
  float* posed_faces = nullptr;                // [F + 1, kPosedFaceFloats]
  float* sums = nullptr;                       // [V, kVertexSumFloats]
  float* signs = nullptr;  // [3 F] like vertex_faces: sign with which the rotation was added
};

// The canonical mesh with the adjacency that walks and searches need: the face across an edge (-1:
// none) and the faces at a vertex.
struct MeshArrays {
  size_t face_count = 0;
  const int32_t* faces = nullptr;              // [F, 3]
  const int32_t* face_neighbors = nullptr;     // [F, 3] as MeshTopology (flame/topology.h)
  const int8_t* neighbor_edges = nullptr;      // [F, 3]
  const int32_t* vertex_face_begin = nullptr;  // [V + 1]
  const int32_t* vertex_faces = nullptr;       // [3 F]
  const float* vertices = nullptr;             // [V, kSurfaceVertexFloats]
};

// The corner of `face` [3] that the vertex is; it must be one of them.
COSPLAT_HD int CornerOf(const int32_t* face, size_t vertex) {
  return size_t(face[0]) == vertex ? 0 : size_t(face[1]) == vertex ? 1 : 2;
}

// How a frame's expression corrects the Gaussians (avatar/math/correct.h); none if count is 0.
struct CorrectionArrays {
  size_t count = 0;                // K
  const float* bases = nullptr;    // [N, K, kCorrectionNumbers]
  const float* weights = nullptr;  // [K] of this frame
};

// The light of the world (avatar/math/light.h); none if `coefficients` is null.
struct LightArrays {
  const float* coefficients = nullptr;  // [kLightTerms, 3]
  const float* mean = nullptr;  // [V, kLightTerms] subtracted from the vertices' terms, or null
  float black = 0;              // the coefficient of black
};

// Gaussians on the triangles of a posed mesh; the triangles must exist.
struct EmbeddedArrays {
  size_t count = 0;
  const int32_t* triangle = nullptr;       // [N]
  const float* barycentric = nullptr;      // [N, 2] (u, v)
  const float* offset = nullptr;           // [N, 3] (du, dv, d)
  const float* rotation = nullptr;         // [N, 4]
  const float* scale_log = nullptr;        // [N, 3]
  const int32_t* faces = nullptr;          // [F, 3]
  const float* vertices = nullptr;         // [V, kSurfaceVertexFloats]
  const float* canonical_areas = nullptr;  // [F, 4] at the corners; the fourth is unused
  // The Gaussians' own, which corrections and light change.
  const float* opacity_logit = nullptr;  // [N]
  const float* color_dc = nullptr;       // [N, 3]
  CorrectionArrays corrections;
  LightArrays light;
};

// The arrays of PosedGaussians (avatar/surface/binding.h).
template <class T>
struct PosedArrays {
  T* position = nullptr;
  T* rotation = nullptr;
  T* scale_log = nullptr;
  T* frame = nullptr;
  T* opacity_logit = nullptr;  // with corrections only
  T* color_dc = nullptr;       // with corrections or light only
};

// Derivatives, overwritten. corners: [N, 3, kSurfaceVertexFloats], each Gaussian's contribution to
// the vertices of its triangle, or null.
struct EmbeddedGradients {
  float* offset = nullptr;
  float* rotation = nullptr;
  float* scale_log = nullptr;
  float* corners = nullptr;
  float* corrections = nullptr;  // [N, K, kCorrectionNumbers]
  // With light only.
  float* color_dc = nullptr;   // [N, 3]; may be that of the posed Gaussians
  float* log_light = nullptr;  // [N, 3] for each Gaussian's own logarithm of the light
};

// Kernels for ForEachRow (splat/device/for_each.h), implemented in avatar/surface/kernels/surface.h
// and embed.h.

// One row per face.
struct PoseFacesKernel {
  SurfaceArrays s;
};
// One row per vertex.
struct PoseVerticesKernel {
  SurfaceArrays s;
};
struct VerticesVjpKernel {
  SurfaceArrays s;
  const float* d_vertices;  // [V, kSurfaceVertexFloats]
  float* d_sums;            // [V, kSurfaceVertexFloats]
};
struct FacesVjpKernel {
  SurfaceArrays s;
  const float* d_sums;  // [V, kSurfaceVertexFloats]
  float* d_corners;     // [F, 3, 3]
};
// One row per Gaussian.
struct EmbedKernel {
  EmbeddedArrays gaussians;
  PosedArrays<float> out;
};
struct EmbedVjpKernel {
  EmbeddedArrays gaussians;
  PosedArrays<const float> d_posed;  // a null `frame` counts as zero
  EmbeddedGradients out;
};
// By avatar/math/rigid_embed.h; corrections are not used.
struct RigidEmbedKernel {
  EmbeddedArrays gaussians;
  const float* posed_faces;  // [F, kPosedFaceFloats]
  PosedArrays<float> out;
};
// Run on SIMD packs, compiled per instruction set.
void RunOnHost(size_t n, const PoseFacesKernel& kernel);
void RunOnHost(size_t n, const PoseVerticesKernel& kernel);
void RunOnHost(size_t n, const VerticesVjpKernel& kernel);
void RunOnHost(size_t n, const FacesVjpKernel& kernel);
void RunOnHost(size_t n, const EmbedKernel& kernel);
void RunOnHost(size_t n, const EmbedVjpKernel& kernel);
void RunOnHost(size_t n, const RigidEmbedKernel& kernel);

// The Gaussians of each face in ascending order: index[begin[f] .. begin[f + 1]).
struct FaceListArrays {
  const uint32_t* begin = nullptr;  // [F + 1]
  const uint32_t* index = nullptr;  // [N]
};
// Writes the sort keys (faces) and values (Gaussians) for FaceListArrays.
struct FaceKeys {
  const int32_t* triangle;
  View<uint32_t> keys, values;
  COSPLAT_HD void operator()(size_t i) const {
    keys[i] = uint32_t(triangle[i]);
    values[i] = uint32_t(i);
  }
};

}  // namespace cosplat

// The posed surface that Gaussians are embedded on: per vertex a position, a normal, the rotation
// from the canonical mesh and the mean area around it; and the derivative of all of them.
//
// FLAME's posed vertices -> Surface::Pose -> avatar/surface/binding.h; backward: dL/d(surface
// vertices) -> Surface::Backward -> d_vertices -> FlamePoser::Backward. On the host or on a device,
// whose memory then holds all arrays except faces() and topology(). Sums are computed in a fixed
// order: results are bit-identical for any number of threads.
#pragma once

#include <vector>

#include "avatar/math/embed.h"
#include "avatar/model/avatar_model.h"
#include "flame/topology.h"
#include "splat/device/buffer.h"

namespace cosplat {

struct MeshArrays;  // avatar/surface/kernels/arrays.h
struct SurfaceArrays;
using SurfaceVertex = math::SurfaceVertex<float>;

// A point on a mesh: a face and the weights (u, v) of its vertices 0 and 1; that of vertex 2 is
// 1 - u - v.
struct SurfacePoint {
  int32_t triangle = 0;
  std::array<float, 2> barycentric{};
};

class Surface {
 public:
  // Starts in the canonical pose. Keeps a reference to the stream. Throws Error when the mesh is
  // not a 2-manifold (see BuildTopology), has no faces, or has a non-finite coordinate.
  explicit Surface(const CanonicalMesh& mesh, Stream& stream = HostStream());

  // vertices: [V, 3] metres, in host memory. Throws Error on a wrong count or a non-finite
  // coordinate.
  void CheckVertices(View<const float> vertices) const;

  // vertices: [V, 3] metres, in the stream's memory. On the host, throws as CheckVertices does; the
  // surface then keeps its last pose. A collapsed face has no weight in the normals and rotations
  // of its vertices; a vertex whose faces have all collapsed gets the identity and a zero normal.
  void Pose(View<const float> vertices);

  // d_surface [V]: dL/d(vertices()) at the last pose -> d_vertices [V, 3], overwritten. The
  // canonical mesh is held fixed.
  void Backward(const Buffer<SurfaceVertex>& d_surface, Buffer<float>& d_vertices);

  Stream& stream() const { return *stream_; }
  size_t vertex_count() const { return vertices_.size(); }
  const std::vector<std::array<int32_t, 3>>& faces() const { return faces_; }
  const MeshTopology& topology() const { return topology_; }
  const Buffer<SurfaceVertex>& vertices() const { return vertices_; }    // [V] at the last pose
  const Buffer<SurfaceVertex>& canonical() const { return canonical_; }  // [V]
  // [F, 4] areas of canonical() at the face's corners; the fourth number is unused.
  const Buffer<float>& canonical_areas() const { return canonical_areas_; }
  // The mesh and its last pose as kernel arguments; only Pose may write to them.
  SurfaceArrays Arrays() const;
  // The canonical mesh and its adjacency as kernel arguments.
  MeshArrays CanonicalArrays() const;
  size_t allocated_bytes() const;  // bytes of the stream's memory

 private:
  void UploadMesh(const CanonicalMesh& mesh);
  void PoseCanonically(const CanonicalMesh& mesh);

  std::vector<std::array<int32_t, 3>> faces_;
  MeshTopology topology_;
  Stream* stream_;
  // In the stream's memory, laid out as in avatar/surface/kernels/arrays.h: the mesh,
  Buffer<int32_t> face_vertices_, face_neighbors_, vertex_face_begin_, vertex_faces_;
  Buffer<int32_t> corner_places_;
  Buffer<int8_t> neighbor_edges_;
  Buffer<math::Mat3<float>> canonical_frames_;
  Buffer<SurfaceVertex> canonical_;
  Buffer<float> canonical_areas_;
  // its last pose,
  Buffer<SurfaceVertex> vertices_;
  Buffer<float> posed_faces_, sums_, signs_;
  // and the scratch memory of Backward.
  Buffer<SurfaceVertex> d_sums_;
  Buffer<float> d_corners_;
};

// Area of one face and of the whole mesh in square metres. Throw Error on a vertex that does not
// exist.
double FaceArea(const CanonicalMesh& mesh, size_t face);
double SurfaceArea(const CanonicalMesh& mesh);

// Factor that converts lengths published "in units of a FLAME mesh enlarged four times" (0.008,
// 0.02, 0.2 and the learning rate of d) to this mesh's units: the square root of the ratio of the
// total area to that of the enlarged template. 0.25 for FLAME's template in metres, 1 for the
// template enlarged four times.
float MeshUnit(const CanonicalMesh& mesh);

}  // namespace cosplat

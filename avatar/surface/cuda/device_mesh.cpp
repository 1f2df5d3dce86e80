#include "avatar/surface/cuda/device_mesh.h"

#include "splat/device/memory_part.h"

namespace cosplat::cuda {

DeviceMesh::DeviceMesh(const Surface& surface, cudaStream_t stream) {
  const MeshArrays host = surface.CanonicalArrays();
  const size_t faces = host.face_count, vertices = surface.vertex_count();
  faces_.Upload(host.faces, 3 * faces, stream);
  face_neighbors_.Upload(host.face_neighbors, 3 * faces, stream);
  neighbor_edges_.Upload(host.neighbor_edges, 3 * faces, stream);
  vertex_face_begin_.Upload(host.vertex_face_begin, vertices + 1, stream);
  vertex_faces_.Upload(host.vertex_faces, 3 * faces, stream);
  vertices_.Upload(host.vertices, kSurfaceVertexFloats * vertices, stream);
  arrays_ = {faces,
             faces_.data(),
             face_neighbors_.data(),
             neighbor_edges_.data(),
             vertex_face_begin_.data(),
             vertex_faces_.data(),
             vertices_.data()};
}

size_t DeviceMesh::held() const {
  return HeldBy(
      faces_, face_neighbors_, vertex_face_begin_, vertex_faces_, neighbor_edges_, vertices_);
}

}  // namespace cosplat::cuda

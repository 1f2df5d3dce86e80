#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <algorithm>

#include "flame/halfedges.h"
#include "splat/base/error.h"

namespace cosplat::internal {
namespace {

using Mesh = OpenMesh::TriConnectivity;  // connectivity only, without positions
using Faces = std::vector<std::array<int32_t, 3>>;

Mesh BuildMesh(const std::string& name, const Faces& faces, int vertex_count) {
  Mesh mesh;
  mesh.reserve(vertex_count, 3 * faces.size() / 2 + vertex_count, faces.size());
  for (int v = 0; v < vertex_count; ++v) mesh.add_vertex();
  for (size_t f = 0; f < faces.size(); ++f) {
    const auto handle = mesh.add_face(Mesh::VertexHandle(faces[f][0]),
                                      Mesh::VertexHandle(faces[f][1]),
                                      Mesh::VertexHandle(faces[f][2]));
    if (!handle.is_valid() || size_t(handle.idx()) != f)
      throw Error(name,
                  "faces[" + std::to_string(f) + "]",
                  "cannot be joined to its neighbours: not a manifold surface");
  }
  if (mesh.n_faces() != faces.size() || mesh.n_vertices() != size_t(vertex_count))
    throw Error(name,
                "faces",
                "adjacency kept " + std::to_string(mesh.n_faces()) + " of " +
                    std::to_string(faces.size()) + " faces and " +
                    std::to_string(mesh.n_vertices()) + " of " + std::to_string(vertex_count) +
                    " vertices");
  return mesh;
}

void FillNeighbors(const Mesh& mesh, const Faces& faces, MeshTopology& topology) {
  topology.face_neighbors.assign(faces.size(), {-1, -1, -1});
  topology.neighbor_edges.assign(faces.size(), {-1, -1, -1});
  for (const auto h : mesh.halfedges()) {
    if (h.is_boundary() || h.opp().is_boundary()) continue;
    const int f = h.face().idx();
    const int g = h.opp().face().idx();
    const int edge = EdgeFrom(faces[f], h.from().idx());
    topology.face_neighbors[f][edge] = g;
    topology.neighbor_edges[f][edge] = int8_t(EdgeFrom(faces[g], h.to().idx()));
  }
}

void FillBoundaryLoops(const Mesh& mesh, MeshTopology& topology) {
  std::vector<bool> seen(mesh.n_halfedges());
  for (const auto start : mesh.halfedges()) {
    if (!start.is_boundary() || seen[start.idx()]) continue;
    std::vector<int32_t> loop;
    for (auto h = start; !seen[h.idx()]; h = h.next()) {
      seen[h.idx()] = true;
      loop.push_back(h.from().idx());
    }
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    topology.boundary_loops.push_back(std::move(loop));
  }
}

}  // namespace

void FillFromHalfedges(const std::string& name, const Faces& faces, MeshTopology& topology) {
  const Mesh mesh = BuildMesh(name, faces, topology.vertex_count);
  FillNeighbors(mesh, faces, topology);
  FillBoundaryLoops(mesh, topology);
}

}  // namespace cosplat::internal

#include "flame/topology.h"

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <algorithm>
#include <unordered_map>

#include "splat/base/error.h"

namespace cosplat {
namespace {

using Mesh = OpenMesh::TriConnectivity;  // connectivity only, without positions
using Faces = std::vector<std::array<int32_t, 3>>;

std::string FaceField(size_t f) { return "faces[" + std::to_string(f) + "]"; }

// Throws Error, with names, for problems that OpenMesh would only report on stderr.
void CheckFaces(const std::string& name, const Faces& faces, int vertex_count) {
  std::unordered_map<uint64_t, size_t> face_of_edge;
  face_of_edge.reserve(3 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const int32_t a = faces[f][i];
      const int32_t b = faces[f][(i + 1) % 3];
      if (a < 0 || a >= vertex_count)
        throw Error(name,
                    FaceField(f),
                    "refers to vertex " + std::to_string(a) + ", but there are only " +
                        std::to_string(vertex_count));
      if (a == b) throw Error(name, FaceField(f), "uses vertex " + std::to_string(a) + " twice");
      const auto [entry, fresh] = face_of_edge.emplace(uint64_t(a) << 32 | uint32_t(b), f);
      if (!fresh)
        throw Error(name,
                    FaceField(f),
                    "runs along edge " + std::to_string(a) + "-" + std::to_string(b) +
                        " the same way as face " + std::to_string(entry->second) +
                        ": not a manifold surface");
    }
  }
}

Mesh BuildMesh(const std::string& name, const Faces& faces, int vertex_count) {
  CheckFaces(name, faces, vertex_count);
  Mesh mesh;
  mesh.reserve(vertex_count, 3 * faces.size() / 2 + vertex_count, faces.size());
  for (int v = 0; v < vertex_count; ++v) mesh.add_vertex();
  for (size_t f = 0; f < faces.size(); ++f) {
    const auto handle = mesh.add_face(Mesh::VertexHandle(faces[f][0]),
                                      Mesh::VertexHandle(faces[f][1]),
                                      Mesh::VertexHandle(faces[f][2]));
    if (!handle.is_valid() || size_t(handle.idx()) != f)
      throw Error(name, FaceField(f), "cannot be joined to its neighbours: not a manifold surface");
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

// Which edge of `face` starts at vertex `from`.
int EdgeFrom(const std::array<int32_t, 3>& face, int32_t from) {
  return face[0] == from ? 0 : face[1] == from ? 1 : 2;
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

void FillVertexFaces(const Faces& faces, MeshTopology& topology) {
  auto& begin = topology.vertex_face_begin;
  begin.assign(topology.vertex_count + 1, 0);
  for (const auto& face : faces)
    for (int32_t v : face) ++begin[v + 1];
  for (int v = 0; v < topology.vertex_count; ++v) begin[v + 1] += begin[v];
  topology.vertex_faces.resize(3 * faces.size());
  std::vector<int32_t> next(begin.begin(), begin.end() - 1);
  for (size_t f = 0; f < faces.size(); ++f)
    for (int32_t v : faces[f]) topology.vertex_faces[next[v]++] = int32_t(f);
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

void FillComponents(MeshTopology& topology) {
  const size_t count = topology.face_neighbors.size();
  topology.face_component.assign(count, -1);
  std::vector<int32_t> stack;
  for (size_t f = 0; f < count; ++f) {
    if (topology.face_component[f] >= 0) continue;
    const int component = topology.component_count++;
    topology.face_component[f] = component;
    stack.push_back(int32_t(f));
    while (!stack.empty()) {
      const int32_t g = stack.back();
      stack.pop_back();
      for (int32_t n : topology.face_neighbors[g]) {
        if (n < 0 || topology.face_component[n] >= 0) continue;
        topology.face_component[n] = component;
        stack.push_back(n);
      }
    }
  }
}

}  // namespace

MeshTopology BuildTopology(const std::string& name, const Faces& faces, int vertex_count) {
  const Mesh mesh = BuildMesh(name, faces, vertex_count);
  MeshTopology topology;
  topology.vertex_count = vertex_count;
  FillNeighbors(mesh, faces, topology);
  FillVertexFaces(faces, topology);
  FillBoundaryLoops(mesh, topology);
  FillComponents(topology);
  return topology;
}

}  // namespace cosplat

// Adjacency of a triangle mesh: which face lies across each edge, which faces meet at a vertex,
// where the mesh ends, which parts hang together.
//
// FlameModel::faces -> MeshTopology -> walking on triangles, vertex normals (avatar/). Built with
// OpenMesh, which silently drops faces it cannot represent: the counts are compared with the raw
// arrays, which are the truth.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

struct MeshTopology {
  int vertex_count = 0;
  // Edge i of a face joins its corner i to its corner (i + 1) % 3.
  std::vector<std::array<int32_t, 3>> face_neighbors;  // [F] face across edge i; -1: boundary
  std::vector<std::array<int8_t, 3>> neighbor_edges;   // [F] which edge of that face; -1: boundary
  // Faces at vertex v, ascending: vertex_faces[vertex_face_begin[v] .. vertex_face_begin[v + 1]).
  std::vector<int32_t> vertex_face_begin;  // [V + 1]
  std::vector<int32_t> vertex_faces;       // [3 F]
  // Each closed chain of boundary edges as its vertices in order, the mesh on the right-hand side
  // (the direction opposite to the faces' own edges); starts at its smallest vertex index.
  std::vector<std::vector<int32_t>> boundary_loops;
  int component_count = 0;
  std::vector<int32_t> face_component;  // [F] 0-based, numbered by the first face of each
};

// `name` is the model's, for errors. Throws Error on a vertex index out of range, a face that uses
// a vertex twice, and edges or vertices that no 2-manifold has (three faces at an edge, two faces
// running along it the same way, a vertex shared by unconnected fans that OpenMesh refuses).
// Vertices without faces are allowed.
MeshTopology BuildTopology(const std::string& name,
                           const std::vector<std::array<int32_t, 3>>& faces,
                           int vertex_count);

}  // namespace cosplat

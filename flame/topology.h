// Adjacency of a triangle mesh: the face across each edge, the faces at each vertex, boundary loops
// and connected components.
//
// FlameModel::faces -> MeshTopology -> walking on triangles, vertex normals (avatar/). Built with
// OpenMesh, which silently drops faces that it cannot represent; its counts are therefore compared
// with those of the raw arrays.
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
  // The vertices of each closed chain of boundary edges, in order, with the mesh on the right-hand
  // side (opposite to the direction of the faces' own edges); starts at the smallest vertex.
  std::vector<std::vector<int32_t>> boundary_loops;
  int component_count = 0;
  std::vector<int32_t> face_component;  // [F] 0-based, numbered by the first face of each
};

// `name` is the model's, for errors. Throws Error for a vertex index out of range, a face that uses
// a vertex twice, and edges or vertices that are not 2-manifold (three faces at an edge, two faces
// that traverse it in the same direction, a vertex shared by unconnected fans that OpenMesh
// rejects). Vertices without faces are allowed.
MeshTopology BuildTopology(const std::string& name,
                           const std::vector<std::array<int32_t, 3>>& faces,
                           int vertex_count);

}  // namespace cosplat

// The part of a mesh's adjacency that needs half-edges (flame/topology.h).
//
// BuildTopology -> FillFromHalfedges, by OpenMesh (halfedges_openmesh.cpp) or, in builds that do
// not have it, by a table of edges (halfedges_plain.cpp), with equal results.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "flame/topology.h"

namespace cosplat::internal {

// Which edge of `face` starts at vertex `from`.
inline int EdgeFrom(const std::array<int32_t, 3>& face, int32_t from) {
  return face[0] == from ? 0 : face[1] == from ? 1 : 2;
}

// Fills face_neighbors, neighbor_edges and boundary_loops. `faces`: indices in range, no directed
// edge twice; topology.vertex_count and vertex_faces must be set. Throws Error(name, ...) for
// vertices that are not manifold.
void FillFromHalfedges(const std::string& name,
                       const std::vector<std::array<int32_t, 3>>& faces,
                       MeshTopology& topology);

}  // namespace cosplat::internal

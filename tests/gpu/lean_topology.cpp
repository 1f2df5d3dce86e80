// BuildTopology for the lean build, which has no OpenMesh, of meshes that are known to be right:
// who is across each edge and at each vertex, and the boundary.
#include <map>
#include <set>
#include <utility>

#include "flame/topology.h"

namespace cosplat {
namespace {

using Faces = std::vector<std::array<int32_t, 3>>;

void FillBoundaryLoops(const Faces& faces, MeshTopology& topology) {
  std::set<std::pair<int32_t, int32_t>> edges;
  for (const auto& face : faces)
    for (size_t i = 0; i < 3; ++i) edges.insert({face[i], face[(i + 1) % 3]});
  std::map<int32_t, int32_t> next;
  for (const auto& [from, to] : edges)
    if (!edges.count({to, from})) next[to] = from;
  while (!next.empty()) {
    std::vector<int32_t> loop;
    for (auto at = next.begin(); at != next.end();) {
      loop.push_back(at->first);
      const int32_t to = at->second;
      next.erase(at);
      at = next.find(to);
    }
    topology.boundary_loops.push_back(std::move(loop));
  }
}

void FillVertexFaces(const Faces& faces, MeshTopology& topology) {
  std::vector<int32_t>& begin = topology.vertex_face_begin;
  begin.assign(size_t(topology.vertex_count) + 1, 0);
  for (const auto& face : faces)
    for (const int32_t v : face) ++begin[size_t(v) + 1];
  for (size_t v = 0; v < size_t(topology.vertex_count); ++v) begin[v + 1] += begin[v];
  std::vector<int32_t> next(begin.begin(), begin.end() - 1);
  topology.vertex_faces.resize(3 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (const int32_t v : faces[f]) topology.vertex_faces[size_t(next[size_t(v)]++)] = int32_t(f);
}

void FillNeighbors(const Faces& faces, MeshTopology& topology) {
  std::map<std::pair<int32_t, int32_t>, std::pair<size_t, int>> face_along;
  for (size_t f = 0; f < faces.size(); ++f)
    for (int edge = 0; edge < 3; ++edge)
      face_along[{faces[f][edge], faces[f][(edge + 1) % 3]}] = {f, edge};
  topology.face_neighbors.assign(faces.size(), {-1, -1, -1});
  topology.neighbor_edges.assign(faces.size(), {-1, -1, -1});
  for (const auto& [ends, place] : face_along) {
    const auto other = face_along.find({ends.second, ends.first});
    if (other == face_along.end()) continue;
    topology.face_neighbors[place.first][place.second] = int32_t(other->second.first);
    topology.neighbor_edges[place.first][place.second] = int8_t(other->second.second);
  }
}

}  // namespace

MeshTopology BuildTopology(const std::string&, const Faces& faces, int vertex_count) {
  MeshTopology topology;
  topology.vertex_count = vertex_count;
  FillVertexFaces(faces, topology);
  FillNeighbors(faces, topology);
  FillBoundaryLoops(faces, topology);
  return topology;
}

}  // namespace cosplat

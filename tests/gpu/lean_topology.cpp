// BuildTopology for the lean build, which has no OpenMesh: the faces at each vertex and the
// boundary, of meshes that are known to be right. Nothing there walks.
#include <map>
#include <set>
#include <utility>

#include "flame/topology.h"

namespace cosplat {
namespace {

void FillBoundaryLoops(const std::vector<std::array<int32_t, 3>>& faces, MeshTopology& topology) {
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

}  // namespace

MeshTopology BuildTopology(const std::string&,
                           const std::vector<std::array<int32_t, 3>>& faces,
                           int vertex_count) {
  MeshTopology topology;
  topology.vertex_count = vertex_count;
  std::vector<int32_t>& begin = topology.vertex_face_begin;
  begin.assign(size_t(vertex_count) + 1, 0);
  for (const auto& face : faces)
    for (const int32_t v : face) ++begin[size_t(v) + 1];
  for (size_t v = 0; v < size_t(vertex_count); ++v) begin[v + 1] += begin[v];
  std::vector<int32_t> next(begin.begin(), begin.end() - 1);
  topology.vertex_faces.resize(3 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (const int32_t v : faces[f]) topology.vertex_faces[size_t(next[size_t(v)]++)] = int32_t(f);
  FillBoundaryLoops(faces, topology);
  return topology;
}

}  // namespace cosplat

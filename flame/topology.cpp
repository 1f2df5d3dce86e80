#include "flame/topology.h"

#include <unordered_map>

#include "flame/halfedges.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using Faces = std::vector<std::array<int32_t, 3>>;

std::string FaceField(size_t f) { return "faces[" + std::to_string(f) + "]"; }

// Before OpenMesh sees them, which would only report them on stderr.
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
                    Format("refers to vertex {}, but there are only {}", a, vertex_count));
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
  CheckFaces(name, faces, vertex_count);
  MeshTopology topology;
  topology.vertex_count = vertex_count;
  FillVertexFaces(faces, topology);
  internal::FillFromHalfedges(name, faces, topology);
  FillComponents(topology);
  return topology;
}

}  // namespace cosplat

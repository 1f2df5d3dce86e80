#include <algorithm>
#include <unordered_map>

#include "flame/halfedges.h"
#include "splat/base/error.h"

namespace cosplat::internal {
namespace {

using Faces = std::vector<std::array<int32_t, 3>>;

uint64_t KeyOf(int32_t from, int32_t to) { return uint64_t(from) << 32 | uint32_t(to); }

void JoinNeighbors(const Faces& faces, MeshTopology& topology) {
  std::unordered_map<uint64_t, int32_t> face_along;  // by directed edge
  face_along.reserve(3 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (size_t i = 0; i < 3; ++i)
      face_along[KeyOf(faces[f][i], faces[f][(i + 1) % 3])] = int32_t(f);
  topology.face_neighbors.assign(faces.size(), {-1, -1, -1});
  topology.neighbor_edges.assign(faces.size(), {-1, -1, -1});
  for (size_t f = 0; f < faces.size(); ++f)
    for (size_t i = 0; i < 3; ++i) {
      const int32_t from = faces[f][i], to = faces[f][(i + 1) % 3];
      const auto other = face_along.find(KeyOf(to, from));
      if (other == face_along.end()) continue;
      topology.face_neighbors[f][i] = other->second;
      topology.neighbor_edges[f][i] = int8_t(EdgeFrom(faces[size_t(other->second)], to));
    }
}

size_t CornerOf(const Faces& faces, int32_t face, int32_t vertex) {
  return size_t(EdgeFrom(faces[size_t(face)], vertex));
}

// Turns about a vertex from face to face, in the direction against the faces' own edges, until the
// boundary or `start` again. Returns the last face and adds the number of faces to `passed`.
int32_t TurnAbout(
    const Faces& faces, const MeshTopology& topology, int32_t vertex, int32_t start, long& passed) {
  int32_t f = start;
  while (true) {
    ++passed;
    const int32_t next = topology.face_neighbors[size_t(f)][(CornerOf(faces, f, vertex) + 2) % 3];
    if (next < 0 || next == start) return f;
    f = next;
  }
}

// A vertex may have one closed fan of faces or any number of open ones.
void CheckFans(const std::string& name,
               const Faces& faces,
               int vertex,
               const MeshTopology& topology) {
  const auto begin = topology.vertex_faces.begin() + topology.vertex_face_begin[size_t(vertex)];
  const auto end = topology.vertex_faces.begin() + topology.vertex_face_begin[size_t(vertex) + 1];
  long passed = 0;
  for (auto f = begin; f != end; ++f)
    if (topology.face_neighbors[size_t(*f)][CornerOf(faces, *f, vertex)] < 0)
      TurnAbout(faces, topology, vertex, *f, passed);
  if (passed == 0 && begin != end) TurnAbout(faces, topology, vertex, *begin, passed);
  if (passed != end - begin)
    throw Error(name,
                "faces[" + std::to_string(*(end - 1)) + "]",
                "cannot be joined to its neighbours at vertex " + std::to_string(vertex) +
                    ": not a manifold surface");
}

// The boundary from b to a of the face edge a-b goes on along the other end of the fan at a.
std::vector<int32_t> BoundaryFrom(const Faces& faces,
                                  const MeshTopology& topology,
                                  size_t f,
                                  size_t edge,
                                  std::vector<bool>& seen) {
  std::vector<int32_t> loop;
  while (!seen[3 * f + edge]) {
    seen[3 * f + edge] = true;
    loop.push_back(faces[f][(edge + 1) % 3]);
    const int32_t a = faces[f][edge];
    long passed = 0;
    f = size_t(TurnAbout(faces, topology, a, int32_t(f), passed));
    edge = (CornerOf(faces, int32_t(f), a) + 2) % 3;
  }
  std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  return loop;
}

void FollowBoundaries(const Faces& faces, MeshTopology& topology) {
  std::vector<bool> seen(3 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (size_t i = 0; i < 3; ++i)
      if (topology.face_neighbors[f][i] < 0 && !seen[3 * f + i])
        topology.boundary_loops.push_back(BoundaryFrom(faces, topology, f, i, seen));
}

}  // namespace

void FillFromHalfedges(const std::string& name, const Faces& faces, MeshTopology& topology) {
  JoinNeighbors(faces, topology);
  for (int v = 0; v < topology.vertex_count; ++v) CheckFans(name, faces, v, topology);
  FollowBoundaries(faces, topology);
}

}  // namespace cosplat::internal

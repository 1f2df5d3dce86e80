// flame/topology.h on small meshes whose adjacency is plain to see.
#include "flame/topology.h"

#include <gtest/gtest.h>

#include "splat/base/error.h"

namespace cosplat::test {
namespace {

using Faces = std::vector<std::array<int32_t, 3>>;

const Faces kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

// Across every edge lies a face that has the same edge, the other way round, and points back.
void ExpectConsistent(const Faces& faces, const MeshTopology& t) {
  ASSERT_EQ(t.face_neighbors.size(), faces.size());
  ASSERT_EQ(t.vertex_faces.size(), 3 * faces.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const int g = t.face_neighbors[f][i];
      const int e = t.neighbor_edges[f][i];
      if (g < 0) {
        EXPECT_EQ(e, -1);
        continue;
      }
      EXPECT_EQ(faces[g][e], faces[f][(i + 1) % 3]);
      EXPECT_EQ(faces[g][(e + 1) % 3], faces[f][i]);
      EXPECT_EQ(t.face_neighbors[g][e], int(f));
      EXPECT_EQ(t.face_component[g], t.face_component[f]);
    }
  for (int v = 0; v < t.vertex_count; ++v)
    for (int k = t.vertex_face_begin[v]; k < t.vertex_face_begin[v + 1]; ++k) {
      const auto& face = faces[t.vertex_faces[k]];
      EXPECT_TRUE(face[0] == v || face[1] == v || face[2] == v);
      if (k > t.vertex_face_begin[v]) {
        EXPECT_LT(t.vertex_faces[k - 1], t.vertex_faces[k]);
      }
    }
}

TEST(Topology, ClosedTetrahedron) {
  const auto t = BuildTopology("mesh", kTetrahedron, 4);
  ExpectConsistent(kTetrahedron, t);
  EXPECT_TRUE(t.boundary_loops.empty());
  EXPECT_EQ(t.component_count, 1);
  EXPECT_EQ(t.face_neighbors[0], (std::array<int32_t, 3>{3, 2, 1}));
}

TEST(Topology, OpenSquareHasOneLoop) {
  const Faces faces = {{0, 1, 2}, {0, 2, 3}};
  const auto t = BuildTopology("mesh", faces, 4);
  ExpectConsistent(faces, t);
  EXPECT_EQ(t.face_neighbors[0], (std::array<int32_t, 3>{-1, -1, 1}));
  EXPECT_EQ(t.face_neighbors[1], (std::array<int32_t, 3>{0, -1, -1}));
  ASSERT_EQ(t.boundary_loops.size(), 1u);
  EXPECT_EQ(t.boundary_loops[0], (std::vector<int32_t>{0, 3, 2, 1}));
}

TEST(Topology, PartsAndLonelyVertices) {
  Faces faces = kTetrahedron;
  for (const auto& f : kTetrahedron) faces.push_back({f[0] + 5, f[1] + 5, f[2] + 5});
  const auto t = BuildTopology("mesh", faces, 10);  // vertices 4 and 9 have no face
  ExpectConsistent(faces, t);
  EXPECT_EQ(t.component_count, 2);
  EXPECT_EQ(t.face_component, (std::vector<int32_t>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(t.vertex_face_begin[4], t.vertex_face_begin[5]);
}

TEST(Topology, TubeHasTwoLoops) {
  Faces faces;
  constexpr int kSides = 6;
  for (int i = 0; i < kSides; ++i) {
    const int n = (i + 1) % kSides;
    faces.push_back({i, n, i + kSides});
    faces.push_back({n, n + kSides, i + kSides});
  }
  const auto t = BuildTopology("mesh", faces, 2 * kSides);
  ExpectConsistent(faces, t);
  ASSERT_EQ(t.boundary_loops.size(), 2u);
  EXPECT_EQ(t.boundary_loops[0].size(), size_t(kSides));
  EXPECT_EQ(t.boundary_loops[1].size(), size_t(kSides));
}

TEST(Topology, TwoFansAtOneVertexKeepEveryFace) {
  const Faces faces = {{0, 1, 2}, {0, 3, 4}};
  ExpectConsistent(faces, BuildTopology("mesh", faces, 5));
}

TEST(Topology, RefusesWhatIsNoSurface) {
  EXPECT_THROW(BuildTopology("mesh", {{0, 1, 3}}, 3), Error);
  EXPECT_THROW(BuildTopology("mesh", {{0, 1, -1}}, 3), Error);
  EXPECT_THROW(BuildTopology("mesh", {{0, 1, 1}}, 3), Error);
  EXPECT_THROW(BuildTopology("mesh", {{0, 1, 2}, {0, 1, 3}}, 4), Error);             // flipped
  EXPECT_THROW(BuildTopology("mesh", {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}, 5), Error);  // three
  Faces cones = kTetrahedron;  // a closed fan around vertex 3, then another face there
  cones.push_back({3, 4, 5});
  EXPECT_THROW(BuildTopology("mesh", cones, 6), Error);
  try {
    BuildTopology("mesh", {{0, 1, 2}, {0, 1, 3}}, 4);
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("mesh: faces[1]"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace cosplat::test

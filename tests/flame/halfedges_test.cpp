// flame/halfedges.h: the table of edges against OpenMesh, on a head with its mouth.
#include "flame/halfedges.h"

#include <gtest/gtest.h>

#include "assets/head/procedural_head.h"
#include "flame/mouth.h"

namespace cosplat::internal {

// flame/halfedges_plain.cpp as it is compiled here.
void FillFromPlainHalfedges(const std::string& name,
                            const std::vector<std::array<int32_t, 3>>& faces,
                            MeshTopology& topology);

}  // namespace cosplat::internal

namespace cosplat::test {
namespace {

TEST(Halfedges, PlainOnesEqualOpenMeshs) {
  const FlameModel head = WithMouth(MakeProceduralHead());
  const MeshTopology expected = BuildTopology("head", head.faces, head.vertex_count);
  MeshTopology plain;
  plain.vertex_count = head.vertex_count;
  plain.vertex_face_begin = expected.vertex_face_begin;
  plain.vertex_faces = expected.vertex_faces;
  internal::FillFromPlainHalfedges("head", head.faces, plain);
  EXPECT_EQ(plain.face_neighbors, expected.face_neighbors);
  EXPECT_EQ(plain.neighbor_edges, expected.neighbor_edges);
  EXPECT_GT(expected.boundary_loops.size(), 1u);
  EXPECT_EQ(plain.boundary_loops, expected.boundary_loops);
}

}  // namespace
}  // namespace cosplat::test

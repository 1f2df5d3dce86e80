// apps/study/avatar_stability/naive_walk.h: right where it has no fault, and its faults are those
// described.
#include "apps/study/avatar_stability/naive_walk.h"

#include <gtest/gtest.h>

#include <limits>

#include "apps/study/avatar_stability/steps.h"

namespace cosplat {
namespace {

constexpr int kRounds = 1000;

// Two triangles that make a parallelogram, or do not, beside the edge from (0, 0) to (0, 1).
Surface TwoTriangles(float right_corner_y) {
  CanonicalMesh mesh;
  mesh.vertices = {0, 0, 0, 0, 1, 0, -1, 0, 0, 1, right_corner_y, 0};
  mesh.faces = {{2, 0, 1}, {3, 1, 0}};
  return Surface(mesh);
}

NaiveWalkResult WalkRight(const Surface& surface, float to_x) {
  const SurfacePoint start{0, {0.25f, 0.5f}};
  const math::Vec3<float> from = PlaceOf(surface, start);
  const auto [du, dv] = StepOn(surface, 0, {to_x - from.x, 0.05f, 0});
  return WalkNaively(surface, start, du, dv, kRounds);
}

TEST(NaiveWalk, IsRightWithinATriangleAndAcrossAParallelogram) {
  for (const float to_x : {-0.1f, 0.2f}) {
    const Surface surface = TwoTriangles(1);
    const NaiveWalkResult end = WalkRight(surface, to_x);
    EXPECT_TRUE(end.ended);
    EXPECT_EQ(end.point.triangle, to_x > 0);
    EXPECT_NEAR(PlaceOf(surface, end.point).x, to_x, 1e-6);
  }
}

TEST(NaiveWalk, BendsWhereTheTrianglesAreNoParallelogram) {
  const Surface surface = TwoTriangles(0.2f);
  const SurfacePoint start{0, {0.25f, 0.5f}};
  const float y = PlaceOf(surface, start).y + 0.05f;
  EXPECT_GT(std::abs(PlaceOf(surface, WalkRight(surface, 0.2f).point).y - y), 0.1f);
}

TEST(NaiveWalk, StaysWhereTheStepIsParallelToAnEdge) {
  const Surface surface = TwoTriangles(1);
  const SurfacePoint start{0, {0.25f, 0.5f}};
  const NaiveWalkResult end = WalkNaively(surface, start, -0.5f, 0.5f, kRounds);
  EXPECT_TRUE(end.ended);
  EXPECT_EQ(end.point.triangle, 0);
  EXPECT_EQ(end.point.barycentric, start.barycentric);
}

TEST(NaiveWalk, NeverEndsOnWhatIsNoNumber) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(WalkNaively(TwoTriangles(1), {0, {0.25f, 0.5f}}, nan, 0.1f, kRounds).ended);
}

}  // namespace
}  // namespace cosplat

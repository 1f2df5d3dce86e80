#include "avatar/surface/walk.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "splat/base/error.h"
#include "tests/avatar/meshes.h"

namespace cosplat {
namespace {

using math::Vec3;
using test::Distance;
using test::PointOf;
using test::StepOf;

// Points are kept 1e-6 of a triangle off its corners and barycentrics are stored as float.
constexpr double kTolerance = 2e-5;

bool Inside(const SurfacePoint& p) {
  const float u = p.barycentric[0], v = p.barycentric[1];
  return u > 0 && v > 0 && 1 - u - v > 0;
}

SurfacePoint RandomPoint(const CanonicalMesh& mesh, std::mt19937& rng) {
  std::uniform_real_distribution<float> uniform;
  const float s = std::sqrt(uniform(rng)), t = uniform(rng);
  return {int32_t(rng() % mesh.faces.size()), {1 - s, s * t}};
}

WalkResult WalkInSpace(const Surface& surface,
                       const CanonicalMesh& mesh,
                       const SurfacePoint& start,
                       const Vec3<double>& step) {
  const auto [du, dv] = StepOf(mesh, start.triangle, step);
  return Walk(surface, start, du, dv);
}

TEST(Walk, StraightOnAnIrregularFlatMesh) {
  const CanonicalMesh mesh = test::SheetMesh(12);
  const Surface surface(mesh);
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> uniform(0.02, 0.98);
  int crossed = 0;
  for (int i = 0; i < 5000; ++i) {
    const SurfacePoint start = RandomPoint(mesh, rng);
    const Vec3<double> from = PointOf(mesh, start);
    const Vec3<double> to{uniform(rng), uniform(rng), 0};
    const WalkResult end = WalkInSpace(surface, mesh, start, to - from);
    ASSERT_LT(Distance(PointOf(mesh, end.point), to), kTolerance) << i;
    ASSERT_TRUE(Inside(end.point));
    ASSERT_NE(end.status, WalkStatus::kInvalid);
    ASSERT_NE(end.status, WalkStatus::kBoundary);
    crossed += end.status == WalkStatus::kCrossed;
  }
  EXPECT_GT(crossed, 4500);
}

// A folded sheet is isometric to the flat one: the same steps lead to the same places.
TEST(Walk, FoldsDoNotBendThePath) {
  const int n = 8;
  const auto fold = [&](float x, float y) {
    const int strip = int(x * n + 0.5f);
    const float width = 1.f / n;  // vertices lie on the folds: every other fold is up
    return std::array<float, 3>{0.6f * width * float(strip), y, strip % 2 ? 0.8f * width : 0.f};
  };
  const CanonicalMesh flat = test::SheetMesh(n, 1, 0), folded = test::SheetMesh(n, 1, 0, 1, fold);
  const Surface flat_surface(flat), folded_surface(folded);
  std::mt19937 rng(4);
  std::normal_distribution<float> step(0, 2);
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const SurfacePoint start = RandomPoint(flat, rng);
    const float du = step(rng), dv = step(rng);
    const WalkResult a = Walk(flat_surface, start, du, dv);
    const WalkResult b = Walk(folded_surface, start, du, dv);
    if (a.status == WalkStatus::kBoundary) continue;
    // Where they end by an edge they may disagree on the face, not on the place.
    ASSERT_LT(Distance(PointOf(flat, a.point), PointOf(flat, b.point)), kTolerance) << i;
    ++compared;
  }
  EXPECT_GT(compared, 800);
}

// Continuing by parallelogram instead of by lengths fails here by far more than the mesh does.
TEST(Walk, FollowsGreatCirclesOnASphere) {
  const CanonicalMesh mesh = test::SphereMesh(5);
  const Surface surface(mesh);
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 300; ++i) {
    const SurfacePoint start = RandomPoint(mesh, rng);
    const Vec3<double> p = math::Normalize(PointOf(mesh, start));
    const Vec3<double> random{normal(rng), normal(rng), normal(rng)};
    const Vec3<double> t = math::Normalize(random - p * math::Dot(random, p));
    const WalkResult end = WalkInSpace(surface, mesh, start, t);  // one radian
    const Vec3<double> expected = p * std::cos(1.0) + t * std::sin(1.0);
    // The polyhedron's edges are 0.05 long and turn its normals by as much.
    ASSERT_LT(Distance(PointOf(mesh, end.point), expected), 0.03) << i;
  }
}

TEST(Walk, StepsParallelToAnEdgeCross) {
  const CanonicalMesh mesh = test::SheetMesh(10);
  const Surface surface(mesh);
  const std::array<std::array<float, 2>, 6> steps{
      {{.5f, 0}, {-.5f, 0}, {0, .5f}, {0, -.5f}, {.5f, -.5f}, {-.5f, .5f}}};
  // Inside, on each edge, on each corner.
  const std::array<std::array<float, 2>, 7> starts{
      {{.3f, .3f}, {.5f, .5f}, {0, .5f}, {.5f, 0}, {1, 0}, {0, 1}, {0, 0}}};
  std::mt19937 rng(6);
  int compared = 0;
  for (int i = 0; i < 10000; ++i) {
    const auto step = steps[i % 6];
    const SurfacePoint start{int32_t(rng() % mesh.faces.size()), starts[rng() % 7]};
    SurfacePoint target = start;  // barycentrics beyond the triangle: the same plane
    for (int k = 0; k < 2; ++k) target.barycentric[k] += step[k];
    const WalkResult end = Walk(surface, start, step[0], step[1]);
    ASSERT_TRUE(Inside(end.point));
    ASSERT_NE(end.status, WalkStatus::kInvalid);
    if (end.status == WalkStatus::kBoundary) continue;
    ASSERT_LT(Distance(PointOf(mesh, end.point), PointOf(mesh, target)), kTolerance) << i;
    ++compared;
  }
  EXPECT_GT(compared, 8500);
}

TEST(Walk, PathsThroughAVertexGoOn) {
  const CanonicalMesh mesh = test::SheetMesh(6, 1, 0);
  const Surface surface(mesh);
  for (int32_t face = 0; face < int32_t(mesh.faces.size()); ++face) {
    const SurfacePoint centroid{face, {1.f / 3, 1.f / 3}};
    for (int corner = 0; corner < 3; ++corner) {
      const Vec3<double> from = PointOf(mesh, centroid);
      const Vec3<double> to = from + (test::VertexOf(mesh, mesh.faces[face][corner]) - from) * 2.0;
      if (std::min({to.x, to.y, 1 - to.x, 1 - to.y}) < 0.01) continue;
      const WalkResult end = WalkInSpace(surface, mesh, centroid, to - from);
      EXPECT_LT(Distance(PointOf(mesh, end.point), to), kTolerance);
    }
  }
}

// The faces of a spike leave so little angle around its tip that a path through the very tip turns
// round it several times.
TEST(Walk, PathsThroughTheTipOfASpikeEnd) {
  CanonicalMesh mesh;
  mesh.vertices = {0, 0, 8, 1, 0, 0, -0.5f, 0.75f, 0, -0.5f, -0.75f, 0};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  const Surface surface(mesh);
  for (int32_t face = 0; face < 3; ++face) {
    const WalkResult end = Walk(surface, {face, {0.5f, 0.25f}}, 0.75f, -0.375f);
    EXPECT_NE(end.status, WalkStatus::kInvalid);
    EXPECT_TRUE(Inside(end.point));
    // Half a step up to the tip, at most half a step down.
    EXPECT_GT(PointOf(mesh, end.point).z, 5.9);
  }
}

TEST(Walk, ImpossibleStepsLeaveThePointWhereItWas) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const CanonicalMesh& mesh : {test::SheetMesh(3), test::SphereMesh(2, 0.1f)}) {
    const Surface surface(mesh);
    const SurfacePoint start{5, {.25f, .5f}};
    for (float bad : {nan, inf, -inf, 1e30f, -1e30f, 3e38f})
      for (const auto& [du, dv] : {std::pair{bad, 0.f}, {0.f, bad}, {bad, bad}, {bad, -bad}}) {
        const WalkResult end = Walk(surface, start, du, dv);
        EXPECT_EQ(end.status, WalkStatus::kInvalid);
        EXPECT_EQ(end.point.triangle, start.triangle);
        EXPECT_EQ(end.point.barycentric, start.barycentric);
      }
    EXPECT_EQ(Walk(surface, {5, {nan, 0}}, 0, 0).status, WalkStatus::kInvalid);
  }
}

TEST(Walk, LongStepsOnAClosedMeshEnd) {
  const CanonicalMesh mesh = test::SphereMesh(3, 0.1f);
  const Surface surface(mesh);
  std::mt19937 rng(7);
  std::normal_distribution<float> step(0, 40);
  for (int i = 0; i < 2000; ++i) {
    const WalkResult end = Walk(surface, RandomPoint(mesh, rng), step(rng), step(rng));
    ASSERT_TRUE(Inside(end.point));
    ASSERT_NE(end.status, WalkStatus::kBoundary);
  }
}

// On a square sheet the rule is plain: what is left of the step goes on along the side.
TEST(Walk, SlidesAlongTheBoundary) {
  const CanonicalMesh mesh = test::SheetMesh(8);
  const Surface surface(mesh);
  std::mt19937 rng(8);
  std::uniform_real_distribution<double> uniform(0.02, 0.98);
  for (int i = 0; i < 2000; ++i) {
    const SurfacePoint start = RandomPoint(mesh, rng);
    const Vec3<double> from = PointOf(mesh, start);
    const Vec3<double> to{1 + uniform(rng), uniform(rng), 0};
    const WalkResult end = WalkInSpace(surface, mesh, start, to - from);
    ASSERT_EQ(end.status, WalkStatus::kBoundary);
    ASSERT_TRUE(Inside(end.point));
    ASSERT_LT(Distance(PointOf(mesh, end.point), {1, to.y, 0}), kTolerance) << i;
  }
}

TEST(Walk, StopsInACorner) {
  const CanonicalMesh mesh = test::SheetMesh(5);
  const Surface surface(mesh);
  std::mt19937 rng(9);
  for (int i = 0; i < 500; ++i) {
    const SurfacePoint start = RandomPoint(mesh, rng);
    const WalkResult end = WalkInSpace(surface, mesh, start, {3, 2, 0});
    ASSERT_EQ(end.status, WalkStatus::kBoundary);
    ASSERT_LT(Distance(PointOf(mesh, end.point), {1, 1, 0}), kTolerance);
  }
}

// Between two sides that meet at 2 degrees, sliding along the one leads into the other again and
// again; the second one met ends the step.
TEST(Walk, StopsInASharpCorner) {
  CanonicalMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 1, 0.035f, 0};
  mesh.faces = {{0, 1, 2}};
  const Surface surface(mesh);
  const WalkResult end = WalkInSpace(surface, mesh, {0, {.2f, .4f}}, {-3, 0.5, 0});
  EXPECT_EQ(end.status, WalkStatus::kBoundary);
  EXPECT_TRUE(Inside(end.point));
  EXPECT_LT(PointOf(mesh, end.point).x, 1e-4);
}

TEST(Walk, FacesWithoutAreaAreWalls) {
  CanonicalMesh mesh;  // the middle triangle (1, 2, 4) is a line
  mesh.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, .5f, .5f, 0};
  mesh.faces = {{0, 1, 2}, {2, 1, 4}, {1, 3, 4}};
  const Surface surface(mesh);
  const WalkResult end = Walk(surface, {0, {.6f, .2f}}, -1.5f, .75f);
  EXPECT_EQ(end.status, WalkStatus::kBoundary);
  EXPECT_EQ(end.point.triangle, 0);
  EXPECT_TRUE(Inside(end.point));
  const WalkResult from_line = Walk(surface, {1, {.4f, .4f}}, -1, -1);
  EXPECT_TRUE(Inside(from_line.point));
}

AvatarModel AvatarAt(const CanonicalMesh& mesh, size_t n, unsigned seed) {
  AvatarModel model = test::RandomAvatar(mesh, n, seed);
  for (float& x : model.gaussians.values[kPosition]) x = 0;
  return model;
}

void Push(AvatarModel& model, const Vec3<double>& step) {
  for (size_t i = 0; i < model.size(); ++i) {
    const auto [du, dv] = StepOf(model.mesh, model.embedding.triangle[i], step);
    model.gaussians.values[kPosition][3 * i] = du;
    model.gaussians.values[kPosition][3 * i + 1] = dv;
  }
}

TEST(WalkAll, MovesReportsAndZeroes) {
  const CanonicalMesh mesh = test::SheetMesh(6);
  const Surface surface(mesh);
  AvatarModel model = AvatarAt(mesh, 400, 1);
  auto& offsets = model.gaussians.values[kPosition];
  Push(model, {0.1, 0.05, 0});
  for (size_t i = 0; i < model.size(); ++i) offsets[3 * i + 2] = 0.5f;
  offsets[0] = offsets[1] = 0;                           // stays
  offsets[3] = std::numeric_limits<float>::quiet_NaN();  // is left where it is
  const AvatarModel before = model;
  const WalkReport report = WalkAll(model, surface, 1000);
  EXPECT_EQ(report.invalid, std::vector<uint32_t>{1});
  EXPECT_FALSE(report.crossed.empty());
  EXPECT_FALSE(report.stopped_at_boundary.empty());
  for (size_t i = 0; i < model.size(); ++i) {
    EXPECT_EQ(offsets[3 * i], 0);
    EXPECT_EQ(offsets[3 * i + 1], 0);
    EXPECT_EQ(offsets[3 * i + 2], 0.5f);
    const bool listed = std::binary_search(report.crossed.begin(), report.crossed.end(), i);
    EXPECT_EQ(listed, model.embedding.triangle[i] != before.embedding.triangle[i]);
  }
  for (int i : {0, 1}) {
    EXPECT_EQ(model.embedding.triangle[i], before.embedding.triangle[i]);
    EXPECT_EQ(model.embedding.barycentric[i], before.embedding.barycentric[i]);
  }
  model.embedding.triangle[3] = 999;
  EXPECT_THROW(WalkAll(model, surface), Error);
}

TEST(WalkAll, BitsDoNotDependOnThreads) {
  const CanonicalMesh mesh = test::SheetMesh(20);
  const auto run = [&](int threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Surface surface(mesh);
    AvatarModel model = AvatarAt(mesh, 5000, 2);
    Push(model, {0.3, 0.1, 0});
    WalkAll(model, surface, 8);
    return std::pair(model.embedding.triangle, model.embedding.barycentric);
  };
  EXPECT_EQ(run(1), run(4));
}

int LargestBoundaryCount(const AvatarModel& model, const Surface& surface) {
  std::vector<int> count(surface.faces().size());
  for (int32_t f : model.embedding.triangle) ++count[f];
  int largest = 0;
  for (size_t f = 0; f < count.size(); ++f) {
    const auto& n = surface.topology().face_neighbors[f];
    if (std::min({n[0], n[1], n[2]}) < 0) largest = std::max(largest, count[f]);
  }
  return largest;
}

TEST(WalkAll, ASteadyPushDoesNotPileUpAtTheBoundary) {
  const CanonicalMesh mesh = test::SheetMesh(10);
  const Surface surface(mesh);
  AvatarModel model = AvatarAt(mesh, 2000, 3);
  const int cap = std::max(25, LargestBoundaryCount(model, surface));
  for (int round = 0; round < 100; ++round) {
    Push(model, {0.02, 0.01, 0});
    WalkAll(model, surface, cap);
    ASSERT_LE(LargestBoundaryCount(model, surface), cap);
  }
  for (size_t i = 0; i < model.size(); ++i)
    ASSERT_TRUE(Inside({model.embedding.triangle[i], model.embedding.barycentric[i]}));
  // The cap did something: without it they gather in the corner.
  AvatarModel uncapped = AvatarAt(mesh, 2000, 3);
  for (int round = 0; round < 100; ++round) {
    Push(uncapped, {0.02, 0.01, 0});
    WalkAll(uncapped, surface, 1 << 30);
  }
  EXPECT_GT(LargestBoundaryCount(uncapped, surface), 4 * cap);
}

TEST(WalkAll, GaussiansStayOnTheirComponent) {
  const CanonicalMesh mesh =
      test::Joined(test::SphereMesh(2, 0.1f), test::SphereMesh(1, 0.02f, {0.05f, 0, 0.08f}));
  const Surface surface(mesh);
  AvatarModel model = AvatarAt(mesh, 500, 4);
  std::vector<int32_t> component;
  for (int32_t f : model.embedding.triangle)
    component.push_back(surface.topology().face_component[f]);
  std::mt19937 rng(5);
  std::normal_distribution<double> normal(0, 0.03);
  for (int round = 0; round < 20; ++round) {
    Push(model, {normal(rng), normal(rng), normal(rng)});
    EXPECT_TRUE(WalkAll(model, surface).invalid.empty());
  }
  for (size_t i = 0; i < model.size(); ++i)
    EXPECT_EQ(surface.topology().face_component[model.embedding.triangle[i]], component[i]);
}

// The mouth's and the neck's loops of the real topology.
TEST(WalkAll, FlameBoundariesHold) {
  if (test::FlameFile().empty()) GTEST_SKIP() << "FLAME's template is not here";
  const CanonicalMesh mesh = test::FlameMesh();
  const Surface surface(mesh);
  AvatarModel model = AvatarAt(mesh, 20000, 6);
  std::vector<int32_t> component;
  for (int32_t f : model.embedding.triangle)
    component.push_back(surface.topology().face_component[f]);
  const int cap = std::max(64, LargestBoundaryCount(model, surface));
  size_t crossed = 0, stopped = 0;
  for (int round = 0; round < 30; ++round) {
    Push(model, round % 2 ? Vec3<double>{0, -0.004, 0} : Vec3<double>{0, 0.001, 0.002});
    const WalkReport report = WalkAll(model, surface);
    crossed += report.crossed.size();
    stopped += report.stopped_at_boundary.size();
    ASSERT_LE(LargestBoundaryCount(model, surface), cap);
    EXPECT_LT(report.invalid.size(), model.size() / 1000);
  }
  for (size_t i = 0; i < model.size(); ++i) {
    ASSERT_TRUE(Inside({model.embedding.triangle[i], model.embedding.barycentric[i]}));
    ASSERT_EQ(surface.topology().face_component[model.embedding.triangle[i]], component[i]);
  }
  EXPECT_GT(crossed, model.size());
  EXPECT_GT(stopped, 100u);
}

}  // namespace
}  // namespace cosplat

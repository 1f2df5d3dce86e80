#include "avatar/surface/surface.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>

#include "splat/base/error.h"
#include "tests/avatar/meshes.h"

namespace cosplat {
namespace {

double AngleBetween(const math::Quat<float>& a, const math::Quat<float>& b) {
  const math::Quat<double> ad{a.w, a.x, a.y, a.z}, bd{b.w, b.x, b.y, b.z};
  const auto r = math::Multiply(math::Conjugate(ad), bd);
  return 2 * std::atan2(std::sqrt(r.x * r.x + r.y * r.y + r.z * r.z), std::abs(r.w));
}

double Norm(const math::Quat<float>& q) { return std::sqrt(math::Dot(q, q)); }

bool AllFinite(const Buffer<SurfaceVertex>& vertices) {
  for (const auto& v : vertices)
    if (!std::isfinite(v.position.x + v.normal.x + v.normal.y + v.normal.z + v.rotation.w +
                       v.rotation.x + v.rotation.y + v.rotation.z + v.area))
      return false;
  return true;
}

Buffer<SurfaceVertex> RandomAdjoint(size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> g;
  Buffer<SurfaceVertex> d(n);
  for (auto& v : d)
    v = {{g(rng), g(rng), g(rng)},
         {g(rng), g(rng), g(rng)},
         {g(rng), g(rng), g(rng), g(rng)},
         g(rng)};
  return d;
}

double Inner(const Buffer<SurfaceVertex>& d, const Buffer<SurfaceVertex>& x) {
  double sum = 0;
  for (size_t v = 0; v < d.size(); ++v)
    sum += double(math::Dot(d[v].position, x[v].position)) + math::Dot(d[v].normal, x[v].normal) +
           math::Dot(d[v].rotation, x[v].rotation) + double(d[v].area) * x[v].area;
  return sum;
}

std::vector<float> Jittered(std::vector<float> vertices, float size, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> normal(0, size);
  for (float& x : vertices) x += normal(rng);
  return vertices;
}

TEST(Surface, CanonicalPoseIsTheIdentity) {
  const Surface surface(test::SphereMesh(2, 0.1f));
  for (size_t v = 0; v < surface.vertex_count(); ++v) {
    const SurfaceVertex& x = surface.vertices()[v];
    EXPECT_NEAR(std::abs(x.rotation.w), 1, 1e-6);
    EXPECT_NEAR(math::Dot(x.normal, x.position), 0.1f, 1e-3f);  // outward
    EXPECT_EQ(x.area, surface.canonical()[v].area);
  }
}

// Quaternion cancellation: the whole head turned by every angle, about several axes.
TEST(Surface, RigidTurnsAreFollowedWithoutJumps) {
  const CanonicalMesh mesh = test::SphereMesh(1, 0.1f);
  Surface surface(mesh);
  for (const std::array<float, 3> axis :
       {std::array<float, 3>{0, 1, 0}, {1, 0, 0}, {0.6f, 0, 0.8f}}) {
    Buffer<SurfaceVertex> last;
    for (int degrees = 0; degrees <= 360; degrees += 2) {
      const double angle = degrees * M_PI / 180;
      surface.Pose(test::Turned(mesh.vertices, axis, angle));
      const math::Quat<float> expected{float(std::cos(angle / 2)),
                                       float(std::sin(angle / 2)) * axis[0],
                                       float(std::sin(angle / 2)) * axis[1],
                                       float(std::sin(angle / 2)) * axis[2]};
      for (size_t v = 0; v < surface.vertex_count(); ++v) {
        const auto& q = surface.vertices()[v].rotation;
        ASSERT_NEAR(Norm(q), 1, 1e-5);
        ASSERT_LT(AngleBetween(q, expected), 1e-4) << degrees;
        if (!last.empty()) {
          ASSERT_LT(AngleBetween(q, last[v].rotation), 2 * 2 * M_PI / 180) << degrees;
        }
      }
      last = surface.vertices();
    }
  }
}

// Half a turn about (1, -1, 0): x and y are the largest components of the quaternion, equal and of
// opposite signs, so that neighbouring faces come out in opposite hemispheres.
TEST(Surface, RotationsOfOppositeSignsDoNotCancel) {
  const CanonicalMesh mesh = test::SphereMesh(2);
  Surface surface(mesh);
  const float h = std::sqrt(0.5f);
  surface.Pose(Jittered(test::Turned(mesh.vertices, {h, -h, 0}, M_PI), 0.02f, 5));
  for (const auto& v : surface.vertices()) EXPECT_LT(AngleBetween(v.rotation, {0, h, -h, 0}), 0.4);
}

TEST(Surface, BackwardMatchesFiniteDifferences) {
  // Unit size, so that a step of 2e-3 lies far above float's rounding (1e-7) and its error, of
  // second order, below 1e-2 of the derivative's scale.
  const CanonicalMesh mesh = test::SphereMesh(1);
  Surface surface(mesh);
  const auto posed = Jittered(test::Turned(mesh.vertices, {0, 1, 0}, 2.2), 0.08f, 7);
  const auto d = RandomAdjoint(surface.vertex_count(), 8);
  surface.Pose(posed);
  Buffer<float> d_vertices;
  surface.Backward(d, d_vertices);
  ASSERT_EQ(d_vertices.size(), posed.size());
  const float h = 2e-3f;
  for (size_t i = 0; i < posed.size(); ++i) {
    auto moved = posed;
    moved[i] = posed[i] + h;
    surface.Pose(moved);
    const double up = Inner(d, surface.vertices());
    moved[i] = posed[i] - h;
    surface.Pose(moved);
    const double down = Inner(d, surface.vertices());
    const double expected = (up - down) / (2.0 * h);
    EXPECT_NEAR(d_vertices[i], expected, 5e-3 * (1 + std::abs(expected))) << i;
  }
}

TEST(Surface, CollapsedFacesAreFiniteAndRecover) {
  const CanonicalMesh mesh = test::SphereMesh(1, 0.1f);
  Surface surface(mesh);
  const auto normal_pose = surface.vertices();
  const auto d = RandomAdjoint(surface.vertex_count(), 3);
  Buffer<float> d_vertices;

  auto collapsed = mesh.vertices;  // one face to a point
  for (int c = 1; c < 3; ++c)
    for (int k = 0; k < 3; ++k)
      collapsed[3 * mesh.faces[0][c] + k] = collapsed[3 * mesh.faces[0][0] + k];
  for (const auto& pose : {collapsed, std::vector<float>(mesh.vertices.size(), 0.5f)}) {
    surface.Pose(pose);
    EXPECT_TRUE(AllFinite(surface.vertices()));
    for (const auto& v : surface.vertices()) EXPECT_NEAR(Norm(v.rotation), 1, 1e-5);
    surface.Backward(d, d_vertices);
    for (float x : d_vertices) EXPECT_TRUE(std::isfinite(x));
  }
  surface.Pose(mesh.vertices);
  for (size_t v = 0; v < normal_pose.size(); ++v)
    EXPECT_EQ(surface.vertices()[v].rotation.w, normal_pose[v].rotation.w);
}

TEST(Surface, FlippedFaceIsFinite) {
  const CanonicalMesh mesh = test::SheetMesh(3);
  Surface surface(mesh);
  auto folded = mesh.vertices;  // an inner vertex pulled across its neighbours: faces turn over
  folded[3 * 5] += 0.9f;
  surface.Pose(folded);
  EXPECT_TRUE(AllFinite(surface.vertices()));
  for (const auto& v : surface.vertices()) EXPECT_NEAR(Norm(v.rotation), 1, 1e-5);
  Buffer<float> d_vertices;
  surface.Backward(RandomAdjoint(surface.vertex_count(), 4), d_vertices);
  for (float x : d_vertices) EXPECT_TRUE(std::isfinite(x));
}

TEST(Surface, SmallMeshGetsTheSameRotations) {
  // A head in metres has faces down to 4e-8 m^2; here they are 1e-10.
  const CanonicalMesh mesh = test::SphereMesh(2, 1e-4f);
  Surface surface(mesh);
  surface.Pose(test::Turned(mesh.vertices, {0, 1, 0}, 2));
  for (const auto& v : surface.vertices())
    EXPECT_LT(AngleBetween(v.rotation, {float(std::cos(1.)), 0, float(std::sin(1.)), 0}), 1e-4);
}

TEST(Surface, BadInputIsNamed) {
  const CanonicalMesh mesh = test::SheetMesh(2);
  Surface surface(mesh);
  auto bad = mesh.vertices;
  bad[7] = std::numeric_limits<float>::quiet_NaN();
  const auto before = surface.vertices()[2].position.y;
  try {
    surface.Pose(bad);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("vertices[2]"), std::string::npos) << e.what();
  }
  EXPECT_EQ(surface.vertices()[2].position.y, before);
  EXPECT_THROW(surface.Pose(std::vector<float>(6)), Error);
  EXPECT_THROW(Surface(CanonicalMesh{}), Error);
  EXPECT_THROW(Surface(CanonicalMesh{mesh.vertices, {{0, 1, 99}}}), Error);
}

TEST(Surface, BitsDoNotDependOnThreads) {
  const CanonicalMesh mesh = test::SphereMesh(4, 0.1f);
  const auto posed = Jittered(mesh.vertices, 0.002f, 1);
  const auto run = [&](int threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Surface surface(mesh);
    surface.Pose(posed);
    Buffer<float> d_vertices;
    surface.Backward(RandomAdjoint(surface.vertex_count(), 2), d_vertices);
    return d_vertices;
  };
  EXPECT_EQ(run(1), run(4));
}

TEST(MeshUnit, FollowsTheMesh) {
  const CanonicalMesh mesh = test::SphereMesh(2, 0.1f);
  EXPECT_NEAR(MeshUnit(test::Scaled(mesh, 4)), 4 * MeshUnit(mesh), 1e-5);
  // FLAME's template, 0.181554 m^2 in all, is the unit enlarged by a quarter.
  const float size = std::sqrt(0.181554f);
  CanonicalMesh square;
  square.vertices = {0, 0, 0, size, 0, 0, size, size, 0, 0, size, 0};
  square.faces = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_NEAR(MeshUnit(square), 0.25, 1e-5);
}

}  // namespace
}  // namespace cosplat

#include "avatar/surface/sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "avatar/surface/binding.h"
#include "splat/base/error.h"
#include "tests/avatar/meshes.h"

namespace cosplat {
namespace {

using math::Vec3;

// Where the canonical surface puts (triangle, barycentrics, d): what Bind computes.
Vec3<double> Embedded(const Surface& surface, const SurfacePoint& p, float d) {
  math::Three<SurfaceVertex> v;
  math::Three<float> area;
  for (int c = 0; c < 3; ++c) {
    v[c] = surface.canonical()[surface.faces()[p.triangle][c]];
    area[c] = v[c].area;
  }
  const auto g =
      math::Embed(v, area, {p.barycentric[0], p.barycentric[1], {0, 0, d}, {1, 0, 0, 0}, {}});
  return {g.position.x, g.position.y, g.position.z};
}

TEST(SampleSurface, SharesFollowTheArea) {
  const CanonicalMesh mesh = test::Joined(test::SheetMesh(7), test::SphereMesh(2, 0.1f));
  Rng rng{3};
  const size_t n = 20000;
  const auto points = SampleSurface(mesh, n, rng);
  ASSERT_EQ(points.size(), n);
  std::vector<int> count(mesh.faces.size());
  for (const auto& p : points) {
    ++count[p.triangle];
    EXPECT_GT(p.barycentric[0], 0);
    EXPECT_GT(p.barycentric[1], 0);
    EXPECT_GT(1 - p.barycentric[0] - p.barycentric[1], 0);
  }
  const double total = SurfaceArea(mesh);
  for (size_t f = 0; f < count.size(); ++f) {
    const double expected = double(n) * FaceArea(mesh, f) / total;
    EXPECT_GE(count[f], std::floor(expected) - 1) << f;
    EXPECT_LE(count[f], std::ceil(expected) + 1) << f;
  }
}

TEST(SampleSurface, UniformInsideATriangle) {
  CanonicalMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.faces = {{0, 1, 2}};
  Rng rng{5};
  const size_t n = 20000;
  double mean[2] = {0, 0}, square[2] = {0, 0};
  for (const auto& p : SampleSurface(mesh, n, rng))
    for (int k = 0; k < 2; ++k) {
      mean[k] += p.barycentric[k] / double(n);
      square[k] += p.barycentric[k] * p.barycentric[k] / double(n);
    }
  for (int k = 0; k < 2; ++k) {  // E u = 1/3, E u^2 = 1/6; five standard errors
    EXPECT_NEAR(mean[k], 1.0 / 3, 5 * 0.236 / std::sqrt(double(n)));
    EXPECT_NEAR(square[k], 1.0 / 6, 5 * 0.2 / std::sqrt(double(n)));
  }
}

TEST(SampleSurface, SeedDecides) {
  const CanonicalMesh mesh = test::SheetMesh(4);
  const auto run = [&](uint64_t seed) {
    Rng rng{seed};
    return SampleSurface(mesh, 100, rng)[57].barycentric;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(SampleSurface, BadMeshIsNamed) {
  Rng rng;
  EXPECT_THROW(SampleSurface(CanonicalMesh{}, 5, rng), Error);
  EXPECT_THROW(SampleSurface(CanonicalMesh{{0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 3}}}, 5, rng),
               Error);
}

TEST(SampleSurface, FlameEyeballsGetTheirShareOfTheArea) {
  if (test::FlameFile().empty()) GTEST_SKIP() << "FLAME's template is not here";
  const CanonicalMesh mesh = test::FlameMesh();
  const Surface surface(mesh);
  Rng rng{1};
  const auto points = SampleSurface(mesh, 10000, rng);
  int eyes = 0;
  for (const auto& p : points) eyes += surface.topology().face_component[p.triangle] != 0;
  EXPECT_NEAR(eyes, 236, 6);  // 2.36 % of the area, 21.8 % of the faces
  EXPECT_NEAR(MeshUnit(mesh), 0.25, 1e-5);
  EXPECT_NEAR(MeshUnit(test::Scaled(mesh, 4)), 1, 4e-5);
}

// Half of these faces have a ten-thousandth of the area.
TEST(SampleFaces, GivesEveryFaceTheSameWhateverItsArea) {
  const CanonicalMesh large = test::SphereMesh(2),
                      mesh = test::Joined(large, test::SphereMesh(2, 0.01f, {3, 0, 0}));
  const auto share = [&](const std::vector<SurfacePoint>& points) {
    int small = 0;
    for (const auto& p : points) small += size_t(p.triangle) >= large.faces.size();
    return double(small) / double(points.size());
  };
  Rng rng{1};
  EXPECT_NEAR(share(SampleFaces(mesh, 10000, rng)), 0.5, 0.02);
  EXPECT_LT(share(SampleSurface(mesh, 10000, rng)), 0.001);
  EXPECT_THROW(SampleFaces(CanonicalMesh{}, 5, rng), Error);
}

TEST(SampleFaces, FlameEyeballsGetTheShareOfTheirFaces) {
  if (test::FlameFile().empty()) GTEST_SKIP() << "FLAME's template is not here";
  const CanonicalMesh mesh = test::FlameMesh();
  const Surface surface(mesh);
  Rng rng{1};
  int eyes = 0;
  for (const auto& p : SampleFaces(mesh, 10000, rng))
    eyes += surface.topology().face_component[p.triangle] != 0;
  EXPECT_NEAR(eyes, 2180, 120);  // 21.8 %; three standard deviations
}

// Points at known places come back, found from a face nearby.
TEST(Reembed, InvertsTheEmbedding) {
  const CanonicalMesh mesh = test::SphereMesh(3, 0.1f);
  const Surface surface(mesh);
  Rng rng{7};
  const auto points = SampleSurface(mesh, 400, rng);
  for (const auto& p : points) {
    const float d = 0.03f * (2 * rng.Uniform() - 1);
    const Vec3<double> x = Embedded(surface, p, d);
    int32_t start = p.triangle;
    for (int hop = 0; hop < 6; ++hop)
      start = surface.topology().face_neighbors[start][rng.Below(3)];
    const EmbeddedPoint e = Reembed(surface, {float(x.x), float(x.y), float(x.z)}, start);
    EXPECT_NEAR(e.d, d, 2e-6f);
    EXPECT_LT(e.residual, 1e-6f);
    EXPECT_LT(test::Distance(Embedded(surface, e.base, e.d), x), 1e-6);
  }
}

TEST(Reembed, FlameSplitsComeBackClosely) {
  if (test::FlameFile().empty()) GTEST_SKIP() << "FLAME's template is not here";
  const CanonicalMesh mesh = test::FlameMesh();
  const Surface surface(mesh);
  Rng rng{8};
  int close = 0;
  const int n = 2000;
  for (const auto& p : SampleSurface(mesh, n, rng)) {
    Vec3<double> x = test::PointOf(mesh, p);
    const double sigma = 0.002;  // the published split size, 0.02 in fourfold units, is 5 mm
    x += Vec3<double>{sigma * rng.Normal(), sigma * rng.Normal(), sigma * rng.Normal()};
    const EmbeddedPoint e = Reembed(surface, {float(x.x), float(x.y), float(x.z)}, p.triangle);
    const Vec3<double> y = Embedded(surface, e.base, e.d);
    EXPECT_NEAR(test::Distance(x, y), e.residual, 2e-6);
    EXPECT_LT(e.residual, 6 * sigma);
    EXPECT_EQ(surface.topology().face_component[e.base.triangle],
              surface.topology().face_component[p.triangle]);
    close += e.residual < 1e-5;
  }
  // The others lie beyond the mouth's or the neck's loop, or in a crease where normals meet.
  EXPECT_GT(close, int(0.98 * n));  // measured: 0.9925
}

TEST(Reembed, BeyondTheBoundaryTheClosestPointIsTaken) {
  const Surface surface(test::SheetMesh(6));
  const EmbeddedPoint e = Reembed(surface, {1.2f, 0.5f, 0.1f}, 0);
  EXPECT_NEAR(e.d, 0.1f, 1e-6);
  EXPECT_NEAR(e.residual, 0.2f, 1e-5);
  const Vec3<double> p = Embedded(surface, e.base, 0);
  EXPECT_LT(test::Distance(p, {1, 0.5, 0}), 1e-5);
}

TEST(Reembed, FarAwayIsBoundedAndFinite) {
  const Surface surface(test::SphereMesh(4, 0.1f));
  for (const std::array<float, 3> x : {std::array<float, 3>{0, 0, 0}, {1e6f, 0, 0}, {0, -5, 3}}) {
    const EmbeddedPoint e = Reembed(surface, x, 3);
    EXPECT_TRUE(std::isfinite(e.d) && std::isfinite(e.residual));
    EXPECT_GT(e.base.barycentric[0], 0);
  }
}

TEST(Reembed, StaysOnItsComponent) {
  const CanonicalMesh mesh =
      test::Joined(test::SphereMesh(2, 0.1f), test::SphereMesh(1, 0.02f, {0, 0, 0.12f}));
  const Surface surface(mesh);
  const int32_t eye = int32_t(mesh.faces.size()) - 1;
  EXPECT_EQ(surface.topology().face_component[Reembed(surface, {0, 0.1f, 0}, eye).base.triangle],
            surface.topology().face_component[eye]);
}

TEST(Reembed, BadInputIsNamed) {
  const Surface surface(test::SheetMesh(2));
  EXPECT_THROW(Reembed(surface, {0, 0, 0}, 8), Error);
  EXPECT_THROW(Reembed(surface, {0, 0, 0}, -1), Error);
  EXPECT_THROW(Reembed(surface, {0, std::numeric_limits<float>::quiet_NaN(), 0}, 0), Error);
}

}  // namespace
}  // namespace cosplat

#include "avatar/surface/binding.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "splat/base/error.h"
#include "tests/avatar/meshes.h"
#include "tests/support/expect_error.h"

namespace cosplat {
namespace {

using test::RandomAvatar;

Buffer<float> RandomBuffer(size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> normal;
  Buffer<float> b(n);
  for (float& x : b) x = normal(rng);
  return b;
}

PosedGaussians RandomAdjoint(size_t n) {
  PosedGaussians d;
  d.position = RandomBuffer(3 * n, 1);
  d.rotation = RandomBuffer(4 * n, 2);
  d.scale_log = RandomBuffer(3 * n, 3);
  d.frame = RandomBuffer(4 * n, 4);
  return d;
}

double Inner(const PosedGaussians& d, const PosedGaussians& x) {
  double sum = 0;
  const auto add = [&](const Buffer<float>& a, const Buffer<float>& b) {
    for (size_t i = 0; i < a.size(); ++i) sum += double(a[i]) * b[i];
  };
  add(d.position, x.position);
  add(d.rotation, x.rotation);
  add(d.scale_log, x.scale_log);
  add(d.frame, x.frame);
  return sum;
}

std::vector<float> Posed(const CanonicalMesh& mesh, float jitter) {
  auto vertices = test::Turned(mesh.vertices, {0.6f, 0, 0.8f}, 1.9);
  const auto noise = RandomBuffer(vertices.size(), 9);
  for (size_t i = 0; i < vertices.size(); ++i) vertices[i] += jitter * noise[i];
  return vertices;
}

bool AllFinite(const Buffer<float>& values) {
  for (float x : values)
    if (!std::isfinite(x)) return false;
  return true;
}
bool AllFinite(const PosedGaussians& g) {
  return AllFinite(g.position) && AllFinite(g.rotation) && AllFinite(g.scale_log) &&
         AllFinite(g.frame);
}

TEST(Bind, CanonicalPoseGivesTheEmbeddedGaussian) {
  CanonicalMesh mesh;
  mesh.vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  mesh.faces = {{0, 1, 2}};
  AvatarModel model = RandomAvatar(mesh, 1, 1);
  model.embedding.barycentric[0] = {0.2f, 0.3f};
  const float offset[3] = {0.1f, 0.1f, 0.5f};
  std::copy(offset, offset + 3, model.gaussians.values[kPosition].begin());
  PosedGaussians out;
  Bind(model, Surface(mesh), out);
  EXPECT_NEAR(out.position[0], 0.4f, 1e-6);  // weight of vertex 1
  EXPECT_NEAR(out.position[1], 0.3f, 1e-6);  // weight of vertex 2
  EXPECT_NEAR(out.position[2], 0.5f, 1e-6);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(out.rotation[k], model.gaussians.values[kRotation][k], 1e-6);
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(out.scale_log[k], model.gaussians.values[kScaleLog][k], 1e-6);
}

TEST(Bind, RigidMotionMovesEverythingAlong) {
  const CanonicalMesh mesh = test::SphereMesh(2, 0.1f);
  const AvatarModel model = RandomAvatar(mesh, 200, 2);
  Surface surface(mesh);
  PosedGaussians rest, turned;
  Bind(model, surface, rest);
  const double angle = 2.5;
  const std::array<float, 3> axis{0.6f, 0, 0.8f};
  surface.Pose(test::Turned(mesh.vertices, axis, angle));
  Bind(model, surface, turned);
  const auto expected =
      test::Turned(std::vector<float>(rest.position.begin(), rest.position.end()), axis, angle);
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(turned.position[i], expected[i], 2e-6f);
  for (size_t i = 0; i < rest.scale_log.size(); ++i)
    EXPECT_NEAR(turned.scale_log[i], rest.scale_log[i], 1e-4f);
}

// Area times 0.25 .. 4 by growing the whole head: the scale grows with its length.
TEST(Bind, ScaleGrowsWithTheMesh) {
  const CanonicalMesh mesh = test::SphereMesh(1, 0.1f);
  const AvatarModel model = RandomAvatar(mesh, 50, 3);
  Surface surface(mesh);
  PosedGaussians out;
  for (float area : {0.25f, 0.5f, 1.f, 2.f, 4.f}) {
    surface.Pose(test::Scaled(mesh, std::sqrt(area)).vertices);
    Bind(model, surface, out);
    for (size_t i = 0; i < out.scale_log.size(); ++i)
      EXPECT_NEAR(
          out.scale_log[i] - model.gaussians.values[kScaleLog][i], 0.5 * std::log(area), 1e-4);
  }
}

// The same avatar on the mesh in metres and on the mesh enlarged four times.
TEST(Bind, UnitsOnlyScaleThePositions) {
  const CanonicalMesh mesh = test::SphereMesh(2, 0.1f);
  const AvatarModel model = RandomAvatar(mesh, 100, 4);
  AvatarModel large = model;
  large.mesh = test::Scaled(mesh, 4);
  for (size_t i = 0; i < model.size(); ++i) large.gaussians.values[kPosition][3 * i + 2] *= 4;
  Surface surface(mesh), large_surface(large.mesh);
  const auto posed = Posed(mesh, 0.005f);
  CanonicalMesh posed_mesh{posed, mesh.faces};
  surface.Pose(posed);
  large_surface.Pose(test::Scaled(posed_mesh, 4).vertices);
  PosedGaussians a, b;
  Bind(model, surface, a);
  Bind(large, large_surface, b);
  for (size_t i = 0; i < a.position.size(); ++i)
    EXPECT_NEAR(b.position[i], 4 * a.position[i], 1e-6f);
  for (size_t i = 0; i < a.rotation.size(); ++i) EXPECT_NEAR(b.rotation[i], a.rotation[i], 1e-6f);
  for (size_t i = 0; i < a.scale_log.size(); ++i)
    EXPECT_NEAR(b.scale_log[i], a.scale_log[i], 1e-5f);
}

TEST(BindBackward, GaussianGradientsMatchFiniteDifferences) {
  const CanonicalMesh mesh = test::SphereMesh(1);
  AvatarModel model = RandomAvatar(mesh, 12, 5);
  Surface surface(mesh);
  surface.Pose(Posed(mesh, 0.08f));
  const PosedGaussians d = RandomAdjoint(model.size());
  Gaussians d_gaussians;
  BindBackward(model, surface, d, d_gaussians);
  PosedGaussians out;
  const float h = 2e-3f;  // as in surface_test.cpp
  for (int attribute : {kPosition, kRotation, kScaleLog}) {
    auto& values = model.gaussians.values[attribute];
    ASSERT_EQ(d_gaussians.values[attribute].size(), values.size());
    for (size_t i = 0; i < values.size(); ++i) {
      const float x = values[i];
      values[i] = x + h;
      Bind(model, surface, out);
      const double up = Inner(d, out);
      values[i] = x - h;
      Bind(model, surface, out);
      const double expected = (up - Inner(d, out)) / (2.0 * h);
      values[i] = x;
      EXPECT_NEAR(d_gaussians.values[attribute][i], expected, 5e-3 * (1 + std::abs(expected)))
          << "attribute " << attribute << " [" << i << "]";
    }
  }
}

TEST(BindBackward, VertexGradientsMatchFiniteDifferences) {
  const CanonicalMesh mesh = test::SphereMesh(1);
  const AvatarModel model = RandomAvatar(mesh, 60, 6);
  Surface surface(mesh);
  const auto posed = Posed(mesh, 0.08f);
  const PosedGaussians d = RandomAdjoint(model.size());
  Gaussians d_gaussians, d_without;
  Buffer<float> d_vertices;
  surface.Pose(posed);
  BindBackward(model, surface, d, d_gaussians, &d_vertices);
  BindBackward(model, surface, d, d_without);
  for (int attribute : {kPosition, kRotation, kScaleLog})
    EXPECT_EQ(d_gaussians.values[attribute], d_without.values[attribute]);
  PosedGaussians out;
  const float h = 2e-3f;
  for (size_t i = 0; i < posed.size(); ++i) {
    auto moved = posed;
    moved[i] = posed[i] + h;
    surface.Pose(moved);
    Bind(model, surface, out);
    const double up = Inner(d, out);
    moved[i] = posed[i] - h;
    surface.Pose(moved);
    Bind(model, surface, out);
    const double expected = (up - Inner(d, out)) / (2.0 * h);
    EXPECT_NEAR(d_vertices[i], expected, 5e-3 * (1 + std::abs(expected))) << i;
  }
}

TEST(BindBackward, EmptyFrameGradientCountsAsZero) {
  const CanonicalMesh mesh = test::SphereMesh(1);
  const AvatarModel model = RandomAvatar(mesh, 5, 1);
  Surface surface(mesh);
  PosedGaussians d = RandomAdjoint(5);
  std::fill(d.frame.begin(), d.frame.end(), 0.f);
  Gaussians with, without;
  BindBackward(model, surface, d, with);
  d.frame.clear();
  BindBackward(model, surface, d, without);
  EXPECT_EQ(with.values[kPosition], without.values[kPosition]);
}

TEST(BindBackward, BitsDoNotDependOnThreads) {
  const CanonicalMesh mesh = test::SphereMesh(4, 0.1f);
  const AvatarModel model = RandomAvatar(mesh, 20000, 7);
  const PosedGaussians d = RandomAdjoint(model.size());
  const auto run = [&](int threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Surface surface(mesh);
    surface.Pose(Posed(mesh, 0.001f));
    Gaussians d_gaussians;
    Buffer<float> d_vertices;
    BindBackward(model, surface, d, d_gaussians, &d_vertices);
    return std::pair(d_gaussians.values[kPosition], d_vertices);
  };
  EXPECT_EQ(run(1), run(4));
}

// A lip folded flat onto itself: normals cancel and flip, yet nothing leaves the surface by more
// than |d|.
TEST(Bind, FoldedSurfaceKeepsTheOffsetBounded) {
  const CanonicalMesh mesh = test::SheetMesh(4);
  AvatarModel model = RandomAvatar(mesh, 300, 8);
  Surface surface(mesh);
  for (int step = 0; step <= 20; ++step) {
    const float angle = float(M_PI) * float(step) / 20;
    auto posed = mesh.vertices;
    for (size_t v = 0; v < posed.size(); v += 3) {
      const float x = posed[v] - 0.5f;
      if (x <= 0) continue;
      posed[v] = 0.5f + x * std::cos(angle);
      posed[v + 2] = x * std::sin(angle);
    }
    surface.Pose(posed);
    PosedGaussians out, flat;
    Bind(model, surface, out);
    AvatarModel on_surface = model;
    for (size_t i = 0; i < model.size(); ++i) on_surface.gaussians.values[kPosition][3 * i + 2] = 0;
    Bind(on_surface, surface, flat);
    ASSERT_TRUE(AllFinite(out));
    for (size_t i = 0; i < model.size(); ++i) {
      float length2 = 0;
      for (int k = 0; k < 3; ++k) {
        const float x = out.position[3 * i + k] - flat.position[3 * i + k];
        length2 += x * x;
      }
      EXPECT_LE(std::sqrt(length2), std::abs(model.gaussians.values[kPosition][3 * i + 2]) + 1e-6f);
    }
  }
}

// When a Gaussian changes triangle nothing jumps: the same place seen from both sides of each edge.
TEST(Bind, NothingJumpsAtAnEdge) {
  const CanonicalMesh mesh = test::SphereMesh(2);
  Surface surface(mesh);
  surface.Pose(Posed(mesh, 0.03f));
  const MeshTopology& topology = surface.topology();
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (int e = 0; e < 3; ++e) {
      AvatarModel model = RandomAvatar(mesh, 2, unsigned(f));
      const int e2 = topology.neighbor_edges[f][e];
      std::array<float, 3> here{}, there{};
      here[e] = there[(e2 + 1) % 3] = 0.37f;
      here[(e + 1) % 3] = there[e2] = 0.63f;
      model.embedding.triangle = {int32_t(f), topology.face_neighbors[f][e]};
      model.embedding.barycentric = {{here[0], here[1]}, {there[0], there[1]}};
      auto& values = model.gaussians.values;
      for (int k = 0; k < 3; ++k) {
        values[kPosition][k] = values[kPosition][3 + k] = k == 2 ? 0.2f : 0;
        values[kScaleLog][3 + k] = values[kScaleLog][k];
      }
      for (int k = 0; k < 4; ++k) values[kRotation][4 + k] = values[kRotation][k];
      PosedGaussians out;
      Bind(model, surface, out);
      float dot = 0;
      for (int k = 0; k < 4; ++k) dot += out.frame[k] * out.frame[4 + k];
      ASSERT_NEAR(std::abs(dot), 1, 1e-5);
      const float sign = dot < 0 ? -1.f : 1.f;
      for (int k = 0; k < 4; ++k) ASSERT_NEAR(out.rotation[k], sign * out.rotation[4 + k], 2e-5f);
      for (int k = 0; k < 3; ++k) {
        ASSERT_NEAR(out.position[k], out.position[3 + k], 2e-6f);
        ASSERT_NEAR(out.scale_log[k], out.scale_log[3 + k], 2e-5f);
      }
    }
}

TEST(Bind, CollapsedMeshIsFinite) {
  const CanonicalMesh mesh = test::SphereMesh(1, 0.1f);
  const AvatarModel model = RandomAvatar(mesh, 100, 9);
  Surface surface(mesh);
  surface.Pose(std::vector<float>(mesh.vertices.size(), 0.25f));
  PosedGaussians out;
  Bind(model, surface, out);
  EXPECT_TRUE(AllFinite(out));
  for (size_t i = 0; i < out.scale_log.size(); ++i)  // a quarter, the lower bound
    EXPECT_NEAR(out.scale_log[i] - model.gaussians.values[kScaleLog][i], std::log(0.25), 1e-5);
  Gaussians d_gaussians;
  Buffer<float> d_vertices;
  BindBackward(model, surface, RandomAdjoint(model.size()), d_gaussians, &d_vertices);
  EXPECT_TRUE(AllFinite(d_gaussians.values[kPosition]));
  for (float x : d_vertices) EXPECT_TRUE(std::isfinite(x));
}

// GaussianAvatars' rule: a face of one point has no size, and so has its Gaussian.
TEST(Bind, RigidOnACollapsedMeshIsFinite) {
  const CanonicalMesh mesh = test::SphereMesh(1, 0.1f);
  AvatarModel model = RandomAvatar(mesh, 100, 9);
  model.embedding.rigid = true;
  Surface surface(mesh);
  surface.Pose(std::vector<float>(mesh.vertices.size(), 0.25f));
  PosedGaussians out;
  Bind(model, surface, out);
  EXPECT_TRUE(AllFinite(out));
  for (const float x : out.position) EXPECT_NEAR(x, 0.25f, 1e-6f);
  for (const float s : out.scale_log) EXPECT_LT(s, -20);
}

TEST(Bind, RigidIsForPlaying) {
  const CanonicalMesh mesh = test::SphereMesh(1, 0.1f);
  AvatarModel model = RandomAvatar(mesh, 5, 9);
  model.embedding.rigid = true;
  Surface surface(mesh);
  Gaussians d_gaussians;
  test::ExpectError([&] { BindBackward(model, surface, RandomAdjoint(5), d_gaussians); },
                    {"no gradient", "GaussianAvatars"});
  model.gaussians.corrections = 1;
  model.gaussians.values[kCorrection].resize(5 * model.gaussians.width(kCorrection));
  PosedGaussians out;
  test::ExpectError([&] { Bind(model, surface, out, std::vector<float>{1}); },
                    {"corrections", "GaussianAvatars"});
}

TEST(Bind, BadModelIsNamed) {
  const CanonicalMesh mesh = test::SheetMesh(2);
  const Surface surface(mesh);
  PosedGaussians out;
  AvatarModel model = RandomAvatar(mesh, 3, 1);
  model.embedding.triangle[2] = 8;
  try {
    Bind(model, surface, out);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("triangle[2]: 8 of 8"), std::string::npos) << e.what();
  }
  model.embedding.triangle[2] = -1;
  EXPECT_THROW(Bind(model, surface, out), Error);
  model.embedding.triangle.pop_back();
  EXPECT_THROW(Bind(model, surface, out), Error);
}

}  // namespace
}  // namespace cosplat

// avatar/surface/packs.cpp through Surface and Bind: on every instruction set of this machine,
// and for numbers of faces and Gaussians that no pack divides, what the formulas give on floats.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <random>

#include "avatar/math/embed.h"
#include "avatar/math/rigid_embed.h"
#include "avatar/surface/binding.h"
#include "tests/avatar/meshes.h"

namespace cosplat::test {
namespace {

using math::Quat;
using math::Three;
using math::Vec3;

class EmbedPacks : public testing::TestWithParam<int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

Vec3<float> V(const Buffer<float>& b, size_t i) { return {b[3 * i], b[3 * i + 1], b[3 * i + 2]}; }
Quat<float> Q(const Buffer<float>& b, size_t i) {
  return {b[4 * i], b[4 * i + 1], b[4 * i + 2], b[4 * i + 3]};
}

// Rounding: numbers are of order 1 and go through some dozens of operations; measured below 1e-6.
constexpr float kTolerance = 4e-6f;

void ExpectNear(const Vec3<float>& a, const Vec3<float>& b) {
  EXPECT_NEAR(a.x, b.x, kTolerance);
  EXPECT_NEAR(a.y, b.y, kTolerance);
  EXPECT_NEAR(a.z, b.z, kTolerance);
}
void ExpectNear(const Quat<float>& a, const Quat<float>& b) {
  EXPECT_NEAR(a.w, b.w, kTolerance);
  EXPECT_NEAR(a.x, b.x, kTolerance);
  EXPECT_NEAR(a.y, b.y, kTolerance);
  EXPECT_NEAR(a.z, b.z, kTolerance);
}

std::vector<float> Wavy(const CanonicalMesh& mesh) {
  auto vertices = Turned(mesh.vertices, {0, 0.6f, 0.8f}, 2.3);
  for (size_t i = 0; i < vertices.size(); ++i) vertices[i] += 0.04f * std::sin(float(3 * i));
  return vertices;
}

Three<SurfaceVertex> CornersOf(const Surface& surface, int32_t face) {
  Three<SurfaceVertex> v;
  for (int c = 0; c < 3; ++c) v[c] = surface.vertices()[surface.faces()[face][c]];
  return v;
}
Three<float> CanonicalAreas(const Surface& surface, int32_t face) {
  Three<float> a;
  for (int c = 0; c < 3; ++c) a[c] = surface.canonical()[surface.faces()[face][c]].area;
  return a;
}
math::EmbeddedGaussian<float> LocalOf(const AvatarModel& m, size_t i) {
  const auto& values = m.gaussians.values;
  return {m.embedding.barycentric[i][0],
          m.embedding.barycentric[i][1],
          V(values[kPosition], i),
          Q(values[kRotation], i),
          V(values[kScaleLog], i)};
}

TEST_P(EmbedPacks, BindIsTheFormula) {
  const CanonicalMesh mesh = SphereMesh(2);
  Surface surface(mesh);
  surface.Pose(Wavy(mesh));
  for (const size_t n : {1, 3, 16, 37}) {
    const AvatarModel model = RandomAvatar(mesh, n, unsigned(n));
    PosedGaussians out;
    Bind(model, surface, out);
    for (size_t i = 0; i < n; ++i) {
      const int32_t face = model.embedding.triangle[i];
      const auto expected =
          Embed(CornersOf(surface, face), CanonicalAreas(surface, face), LocalOf(model, i));
      ExpectNear(V(out.position, i), expected.position);
      ExpectNear(Q(out.rotation, i), expected.rotation);
      ExpectNear(V(out.scale_log, i), expected.scale_log);
      ExpectNear(Q(out.frame, i), expected.frame);
    }
  }
}

TEST_P(EmbedPacks, RigidBindIsItsFormula) {
  const CanonicalMesh mesh = SphereMesh(2);
  Surface surface(mesh);
  const std::vector<float> posed = Wavy(mesh);
  surface.Pose(posed);
  for (const size_t n : {1, 3, 16, 37}) {
    AvatarModel model = RandomAvatar(mesh, n, unsigned(n));
    model.embedding.rigid = true;
    PosedGaussians out;
    Bind(model, surface, out);
    for (size_t i = 0; i < n; ++i) {
      const auto& f = mesh.faces[size_t(model.embedding.triangle[i])];
      Vec3<float> p[3], rest[3];
      for (size_t c = 0; c < 3; ++c) {
        p[c] = surface.vertices()[size_t(f[c])].position;
        rest[c] = surface.canonical()[size_t(f[c])].position;
      }
      const auto local = LocalOf(model, i);
      const auto expected = math::RigidEmbed(
          math::RigidFaceOf(p[0], p[1], p[2]),
          math::RigidGaussian<float>{local.offset, local.rotation, local.scale_log});
      ExpectNear(V(out.position, i), expected.position);
      ExpectNear(Q(out.rotation, i), expected.rotation);
      ExpectNear(V(out.scale_log, i), expected.scale_log);
      // From the canonical face to the posed one, as with colours in the surface's frame.
      ExpectNear(Q(out.frame, i),
                 math::FaceRotation(p[0], p[1], p[2], math::FaceFrame(rest[0], rest[1], rest[2])));
    }
  }
}

TEST_P(EmbedPacks, BindBackwardIsTheFormulasDerivative) {
  const CanonicalMesh mesh = SphereMesh(2);
  Surface surface(mesh);
  surface.Pose(Wavy(mesh));
  constexpr size_t kCount = 37;
  const AvatarModel model = RandomAvatar(mesh, kCount, 3);
  std::mt19937 rng(4);
  std::normal_distribution<float> normal(0, 0.3f);
  PosedGaussians d;
  d.Resize(kCount);
  for (Buffer<float>* b : {&d.position, &d.rotation, &d.scale_log, &d.frame})
    for (float& x : *b) x = normal(rng);
  Buffer<SurfaceVertex> d_surface(surface.vertex_count());
  Gaussians d_gaussians, without;
  Buffer<float> d_vertices, expected_vertices;
  BindBackward(model, surface, d, d_gaussians, &d_vertices);
  BindBackward(model, surface, d, without);
  for (size_t i = 0; i < kCount; ++i) {
    const int32_t face = model.embedding.triangle[i];
    math::EmbeddedGaussian<float> expected;
    Three<SurfaceVertex> corners{};
    EmbedVjp(CornersOf(surface, face),
             CanonicalAreas(surface, face),
             LocalOf(model, i),
             {V(d.position, i), Q(d.rotation, i), V(d.scale_log, i), Q(d.frame, i)},
             expected,
             &corners);
    ExpectNear(V(d_gaussians.values[kPosition], i), expected.offset);
    ExpectNear(Q(d_gaussians.values[kRotation], i), expected.rotation);
    ExpectNear(V(d_gaussians.values[kScaleLog], i), expected.scale_log);
    for (int c = 0; c < 3; ++c) {
      SurfaceVertex& sum = d_surface[mesh.faces[face][c]];
      sum.position += corners[c].position;
      sum.normal += corners[c].normal;
      sum.rotation = sum.rotation + corners[c].rotation;
      sum.area += corners[c].area;
    }
  }
  for (const Attribute a : {kPosition, kRotation, kScaleLog})
    EXPECT_EQ(d_gaussians.values[a], without.values[a]);
  surface.Backward(d_surface, expected_vertices);
  float largest = 1;
  for (const float x : expected_vertices) largest = std::max(largest, std::abs(x));
  for (size_t k = 0; k < d_vertices.size(); ++k)
    EXPECT_NEAR(d_vertices[k], expected_vertices[k], kTolerance * largest);
}

// A face of its own per vertex: the vertex has the face's rotation, normal and area.
TEST_P(EmbedPacks, FacesAreTheFormula) {
  for (const int cells : {1, 3}) {
    const CanonicalMesh mesh = SheetMesh(cells);
    Surface surface(mesh);
    const std::vector<float> posed = Wavy(mesh);
    surface.Pose(posed);
    const auto at = [](const std::vector<float>& vertices, int32_t v) {
      return Vec3<float>{vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
    };
    size_t checked = 0;
    const MeshTopology& topology = surface.topology();
    for (size_t v = 0; v < surface.vertex_count(); ++v) {
      if (topology.vertex_face_begin[v + 1] - topology.vertex_face_begin[v] != 1) continue;
      const auto& f = mesh.faces[topology.vertex_faces[topology.vertex_face_begin[v]]];
      const auto frame = math::FaceFrame(
          at(mesh.vertices, f[0]), at(mesh.vertices, f[1]), at(mesh.vertices, f[2]));
      const Vec3<float> p[3] = {at(posed, f[0]), at(posed, f[1]), at(posed, f[2])};
      const Vec3<float> area = math::AreaVector(p[0], p[1], p[2]);
      ExpectNear(surface.vertices()[v].normal, math::Normalize(area));
      EXPECT_NEAR(surface.vertices()[v].area, math::Length(area), kTolerance);
      ExpectNear(surface.vertices()[v].rotation, math::FaceRotation(p[0], p[1], p[2], frame));
      ++checked;
    }
    EXPECT_GE(checked, 2u);
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets,
                         EmbedPacks,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& info) { return hwy::TargetName(info.param); });

}  // namespace
}  // namespace cosplat::test

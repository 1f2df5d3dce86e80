// Two triangles folded about their common edge, like a lip: points at distance d along the normal
// must neither separate at the fold nor be farther than |d| from the triangles.
#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/study/avatar_stability/cases.h"
#include "apps/study/avatar_stability/sketch.h"
#include "apps/study/avatar_stability/steps.h"
#include "avatar/surface/binding.h"

namespace cosplat {
namespace {

using math::Vec3;

constexpr float kOffset = 0.2f;  // relative to the triangles' height
constexpr int kAcross = 24;      // points on each triangle, from the fold outwards
constexpr double kDegree = 0.017453292519943295;

// The fold from (0, -1, 0) to (0, 1, 0); one triangle to the left, one to the right and turned up.
std::vector<float> FoldedVertices(double degrees) {
  const float c = float(std::cos(degrees * kDegree)), s = float(std::sin(degrees * kDegree));
  return {0, -1, 0, 0, 1, 0, -1, 0, 0, c, 0, s};
}

// Points along y = 0: the left triangle's, then the right's, each from the fold outwards. The two
// on the fold coincide.
AvatarModel PlacesAcrossTheFold() {
  AvatarModel avatar;
  avatar.mesh = {FoldedVertices(0), {{2, 0, 1}, {3, 1, 0}}};  // the outer corner first
  for (int face = 0; face < 2; ++face)
    for (int i = 0; i < kAcross; ++i) {
      const float outwards = float(i) / kAcross;
      avatar.embedding.triangle.push_back(face);
      avatar.embedding.barycentric.push_back({outwards, 0.5f * (1 - outwards)});
    }
  avatar.gaussians.Resize(avatar.embedding.triangle.size());
  for (size_t i = 0; i < avatar.size(); ++i) {
    avatar.gaussians.at(kPosition, i)[2] = kOffset;
    avatar.gaussians.at(kRotation, i)[0] = 1;
  }
  return avatar;
}

// Points [2 kAcross] on the sheet, and the same points offset by each face's own normal.
struct ByFaceNormals {
  std::vector<Vec3<float>> on, off;
  ByFaceNormals(const AvatarModel& avatar, const std::vector<float>& vertices) {
    for (size_t i = 0; i < avatar.size(); ++i) {
      const auto& f = avatar.mesh.faces[avatar.embedding.triangle[i]];
      const Vec3<float> p[3] = {
          VertexAt(vertices, f[0]), VertexAt(vertices, f[1]), VertexAt(vertices, f[2])};
      const auto [u, v] = avatar.embedding.barycentric[i];
      on.push_back(p[0] * u + p[1] * v + p[2] * (1 - u - v));
      off.push_back(on.back() + math::Normalize(math::AreaVector(p[0], p[1], p[2])) * kOffset);
    }
  }
};

std::vector<Vec3<float>> PointsOf(const PosedGaussians& posed) {
  std::vector<Vec3<float>> points;
  for (size_t i = 0; i < posed.size(); ++i)
    points.push_back({posed.position[3 * i], posed.position[3 * i + 1], posed.position[3 * i + 2]});
  return points;
}

// Distance between the two points on the fold, in units of the offset; infinite if a point is
// farther than one offset from the sheet.
double TearOf(const std::vector<Vec3<float>>& on, const std::vector<Vec3<float>>& off) {
  for (size_t i = 0; i < on.size(); ++i)
    if (!(math::Length(off[i] - on[i]) <= 1.0001f * kOffset))
      return std::numeric_limits<double>::infinity();
  return math::Length(off[0] - off[kAcross]) / kOffset;
}

// Cross-section, seen along the fold.
Image8 Profile(const std::vector<Vec3<float>>& on,
               const std::vector<Vec3<float>>& off,
               const SketchColor& ink) {
  constexpr float kScale = 0.42f * kStudyImage;
  Sketch sketch(kStudyImage, kStudyImage);
  const auto line = [&](const auto& points, int i, const SketchColor& color, float width) {
    sketch.Line(0.5f * kStudyImage + kScale * points[i].x,
                0.7f * kStudyImage - kScale * points[i].z,
                0.5f * kStudyImage + kScale * points[i + 1].x,
                0.7f * kStudyImage - kScale * points[i + 1].z,
                color,
                width);
  };
  for (int face = 0; face < 2; ++face)
    for (int i = face * kAcross; i < (face + 1) * kAcross - 1; ++i) {
      line(on, i, kMeshLine, 2);
      line(off, i, ink, 2);
    }
  return sketch.image();
}

}  // namespace

StabilityCase FoldedLipCase() {
  constexpr int kImaged = 120;  // degrees
  StabilityCase c;
  c.key = "folded_lip";
  c.title = "An offset along the normal at a fold";
  c.what =
      "Two triangles are folded about their common edge until they touch; Gaussians lie off them "
      "along the normal. By each face's own normal, one place on the edge becomes two.";
  c.quantity = "tear at the fold, none farther off than its offset";
  c.unit = "offsets";
  c.bound = 1e-3;
  c.naive.name = "The face's normal";
  c.ours.name = "Normals of the vertices, blended";
  c.chart = {"angle of the fold", "degrees", "tear", "offsets", false, false, {}};
  c.chart.curves = {{c.naive.name, {}}, {c.ours.name, {}}};
  const AvatarModel avatar = PlacesAcrossTheFold();
  Surface surface(avatar.mesh);
  PosedGaussians posed;
  for (int degrees = 0; degrees <= 180; degrees += 2) {
    const std::vector<float> vertices = FoldedVertices(degrees);
    surface.Pose(vertices);
    Bind(avatar, surface, posed);
    const ByFaceNormals naive(avatar, vertices);
    const std::vector<Vec3<float>> ours = PointsOf(posed);
    const double tears[2] = {TearOf(naive.on, naive.off), TearOf(naive.on, ours)};
    for (int k : {0, 1}) c.chart.curves[k].points.push_back({double(degrees), tears[k]});
    c.naive.value = std::max(c.naive.value, tears[0]);
    c.ours.value = std::max(c.ours.value, tears[1]);
    if (degrees != kImaged) continue;
    c.naive.image = Profile(naive.on, naive.off, kNaiveInk);
    c.ours.image = Profile(naive.on, ours, kOursInk);
  }
  return c;
}

}  // namespace cosplat

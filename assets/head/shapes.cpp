// Shape directions (proportions of the subject) and pose correctives.

#include <algorithm>
#include <cmath>

#include "assets/head/rig.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

Vec Folded(const Vec& p) { return {std::abs(p.x), p.y, p.z}; }
Vec Outward(const Vec& p, float amount) {  // from the median plane, with no jump at it
  return {amount * std::tanh(p.x / 0.01f), 0, 0};
}

Vec ShapeField(int shape, const Vec& p) {
  const Vec m = Folded(p);
  switch (shape) {
    case 0:  // size
      return 0.030f * (p - Vec{0, -0.02f, -0.03f});
    case 1:  // width
      return {0.045f * p.x, 0, 0};
    case 2:  // length of the head
      return {0, 0, 0.040f * (p.z + 0.03f)};
    case 3:  // height of the face
      return {0, 0.050f * (p.y - 0.03f) * SmoothStep(-0.12f, -0.06f, p.y), 0};
    case 4:  // width of the jaw
      return Outward(p, 0.0040f * Ball(m, {0.050f, -0.042f, 0}, 0.035f));
    case 5:  // chin
      return Ball(p, {0, -0.072f, 0.045f}, 0.025f) * Vec{0, -0.0025f, 0.0035f};
    case 6:  // length of the nose
      return Ball(p, {0, -0.008f, 0.076f}, 0.018f) * Vec{0, -0.0010f, 0.0035f};
    case 7:  // width of the nose
      return Outward(p, 0.0024f * Ball(m, {0.012f, -0.013f, 0.066f}, 0.011f));
    case 8:  // cheek bones
      return Ball(m, {0.048f, 0.006f, 0.028f}, 0.022f) * (Outward(p, 0.0032f) + Vec{0, 0, 0.0014f});
    case 9:  // brow ridge
      return Ball(m, {0.020f, 0.053f, 0.055f}, 0.024f) * Vec{0, 0, 0.0028f};
    case 10:  // forehead and crown
      return SmoothStep(0.05f, 0.14f, p.y) * Vec{0, 0.0050f, 0};
    default:  // neck
      return SmoothStep(-0.06f, -0.10f, p.y) * Vec{0.07f * p.x, 0, 0.05f * (p.z + 0.05f)};
  }
}

// Neck and jaw: skin bulges where it is compressed and thins where it is stretched.
Vec CrossingCorrective(int row, int column, const Vec& p, const Vec& normal, float crossing) {
  static constexpr float kAmount = 0.0016f;
  const Vec q = (p - Vec{0, -0.09f, -0.05f}) * (1 / 0.06f);
  // The rotation's axis; pitch compresses the front or back, yaw and roll a side.
  const int axis = row == column ? row : 3 - row - column;
  const float lever = std::tanh(axis == 0 ? q.z : q.x) * (row >= column ? 1.0f : -1.0f);
  return (kAmount * crossing * lever) * normal;
}

// Lids follow the pitch of their eye; rotation entry (2, 1) is its sine, positive looking down.
Vec LidCorrective(const VertexLabel& l, const Vec& p, bool left, int row, int column) {
  if (l.lid_ring == kNoRing || (p.x > 0) != left || l.upper == 0) return {};
  if (row + column != 3 || row == column) return {};
  const float reach =
      l.lid_ring > 0 ? 1 - 0.3f * float(l.lid_ring) : std::max(0.0f, 1 + 0.2f * float(l.lid_ring));
  const float follow = (l.upper > 0 ? 0.30f : 0.18f) * (1 - l.along * l.along) * reach;
  const Vec d = p - EyeCenter(left);
  return (row > column ? follow : -follow) * Vec{0, -d.z, d.y};
}

}  // namespace

Vec RigidAtEyes(const std::function<Vec(const Vec&)>& field, const Vec& p, Part part) {
  const bool eyeball = part == Part::kLeftEye || part == Part::kRightEye;
  const float rigid = eyeball || part == Part::kSocket ? 1.0f : NearEye(p);
  if (rigid == 0) return field(p);
  return Mix(field(p), field(EyeCenter(p.x > 0)), rigid);
}

std::vector<float> ShapeDirections(const HeadMesh& mesh) {
  std::vector<float> directions;
  for (int s = 0; s < kShapeCount; ++s)
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto field = [&](const Vec& p) { return ShapeField(s, p); };
      const Vec d = RigidAtEyes(field, mesh.positions[v], mesh.labels[v].part);
      directions.insert(directions.end(), {d.x, d.y, d.z});
    }
  return directions;
}

std::vector<float> PoseDirections(const HeadMesh& mesh, const std::vector<float>& weights) {
  const auto normals = VertexNormals(mesh.positions, mesh.faces);
  std::vector<float> directions;
  for (int feature = 0; feature < kFlamePoseFeatures; ++feature) {
    const int joint = 1 + feature / 9, row = feature % 9 / 3, column = feature % 3;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const VertexLabel& l = mesh.labels[v];
      const float w = weights[v * kFlameJoints + joint];
      Vec d{};
      if (joint >= 3) {
        d = LidCorrective(l, mesh.positions[v], joint == 3, row, column);
      } else if (l.part == Part::kSkin && l.lid_ring == kNoRing && l.mouth_ring == kNoRing) {
        d = CrossingCorrective(row, column, mesh.positions[v], normals[v], 4 * w * (1 - w));
      }
      directions.insert(directions.end(), {d.x, d.y, d.z});
    }
  }
  return directions;
}

}  // namespace cosplat::procedural

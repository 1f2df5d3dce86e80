// The surface itself: rotations of opposite sign, degenerate faces.
#include <algorithm>
#include <cmath>

#include "apps/study/avatar_stability/cases.h"
#include "apps/study/avatar_stability/steps.h"

namespace cosplat {
namespace {

using math::Vec3;
constexpr size_t kTurned = 4000;  // Gaussians on the rotating head
constexpr double kDegree = 0.017453292519943295;
constexpr Vec3<float> kMouthCorner{0.026f, -0.04f, 0.056f};  // the left one, of the procedural head
constexpr float kOffset = 0.002f;  // metres along the normal, for every Gaussian

// Angle in degrees between rotation i of both; [N] rows of unit quaternions.
double TurnOf(const Buffer<float>& a, const Buffer<float>& b, size_t i) {
  double dot = 0;
  for (size_t k = 4 * i; k < 4 * i + 4; ++k) dot += double(a[k]) * b[k];
  return 2 * std::acos(std::min(1.0, std::abs(dot))) / kDegree;
}

double LargestTurn(const Buffer<float>& a, const Buffer<float>& b) {
  double max = 0;
  for (size_t i = 0; i < a.size() / 4; ++i) max = std::max(max, TurnOf(a, b, i));
  return max;
}

// From grey (0) to red (1).
void Redden(float by, Gaussians& gaussians, size_t i) {
  float* color = gaussians.at(kColorDc, i);
  color[0] = 0.5f + by;
  color[1] = color[2] = 0.5f - 2 * by;
}

// Grey, blending to red with the angle to the other rule's rotation: fully red at 180 degrees.
Image8 ImageOfTurns(BoundBothWays::Way way, const Buffer<float>& other, const Camera& camera) {
  for (size_t i = 0; i < way.model.size(); ++i)
    Redden(float(TurnOf(way.posed.frame, other, i) / 180), way.model.gaussians, i);
  return ImageOf(way, camera);
}

AvatarModel OffTheSurface(AvatarModel avatar) {
  for (size_t i = 0; i < avatar.size(); ++i) avatar.gaussians.at(kPosition, i)[2] = kOffset;
  return avatar;
}

// The region around the left corner of the mouth, collapsed to a point or mirrored.
std::vector<float> Spoiled(std::vector<float> vertices, bool mirrored) {
  constexpr float kRadius = 0.02f;  // metres
  const Vec3<float> centre = kMouthCorner;
  for (size_t v = 0; v < vertices.size(); v += 3) {
    const Vec3<float> p{vertices[v], vertices[v + 1], vertices[v + 2]};
    if (math::Length(p - centre) > kRadius) continue;
    vertices[v] = mirrored ? 2 * centre.x - p.x : centre.x;
    if (mirrored) continue;
    vertices[v + 1] = centre.y;
    vertices[v + 2] = centre.z;
  }
  return vertices;
}

// Positions from normals and frames that are normalised without a check for zero length.
Buffer<float> UnguardedPositions(const AvatarModel& avatar, const std::vector<float>& vertices) {
  const auto& faces = avatar.mesh.faces;
  std::vector<Vec3<float>> normals(vertices.size() / 3, {0, 0, 0});
  for (const auto& f : faces) {
    const Vec3<float> n = math::AreaVector(
        VertexAt(vertices, f[0]), VertexAt(vertices, f[1]), VertexAt(vertices, f[2]));
    for (const int32_t v : f) normals[v] += n;
  }
  for (Vec3<float>& n : normals) n = n * (1 / std::sqrt(Dot(n, n)));
  Buffer<float> out;
  for (size_t i = 0; i < avatar.size(); ++i) {
    const auto& f = faces[avatar.embedding.triangle[i]];
    const auto [u, v] = avatar.embedding.barycentric[i];
    const float b[3] = {u, v, 1 - u - v};
    Vec3<float> p{0, 0, 0}, n{0, 0, 0};
    for (int c = 0; c < 3; ++c) {
      p += VertexAt(vertices, f[c]) * b[c];
      n += normals[f[c]] * b[c];
    }
    p += n * (avatar.gaussians.at(kPosition, i)[2] / std::sqrt(Dot(n, n)));
    for (const float x : {p.x, p.y, p.z}) out.push_back(x);
  }
  return out;
}

// Whether each Gaussian is non-finite, or farther from its point on the triangle than its offset.
std::vector<bool> Astray(const AvatarModel& avatar,
                         const std::vector<float>& vertices,
                         const Buffer<float>& positions) {
  std::vector<bool> astray(avatar.size());
  for (size_t i = 0; i < avatar.size(); ++i) {
    const auto& f = avatar.mesh.faces[avatar.embedding.triangle[i]];
    const auto [u, v] = avatar.embedding.barycentric[i];
    const Vec3<float> p = VertexAt(vertices, f[0]) * u + VertexAt(vertices, f[1]) * v +
                          VertexAt(vertices, f[2]) * (1 - u - v);
    const Vec3<float> q{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]};
    const Vec3<float> off = q - p;
    astray[i] = !(std::sqrt(Dot(off, off)) <= 1.001f * kOffset);
  }
  return astray;
}

// At their rest positions: grey, and red for those that go astray.
Image8 ImageOfAstray(BoundBothWays::Way way, const std::vector<bool>& astray) {
  for (size_t i = 0; i < astray.size(); ++i) Redden(astray[i], way.model.gaussians, i);
  return ImageOf(way, StudyCamera());
}

StabilityCase OppositeRotationsText() {
  StabilityCase c;
  c.key = "opposite_rotations";
  c.title = "Rotations of opposite sign";
  c.what =
      "A grimacing head turns round once, a degree at a time. q and -q are one rotation; summed as "
      "they come, quaternions cancel where their sign changes. Red: turned away from ours.";
  c.quantity = "largest turn of a Gaussian while the head turns by 1 degree";
  c.unit = "degrees";
  c.bound = 2;
  c.naive.name = "Signs as they come, as released";
  c.ours.name = "Brought to one hemisphere";
  c.chart = {
      "yaw of the head", "degrees", "largest turn of a Gaussian", "degrees", false, true, {}};
  c.chart.curves = {{c.naive.name, {}}, {c.ours.name, {}}};
  return c;
}

}  // namespace

StabilityCase OppositeRotationsCase(const StudyHead& head) {
  StabilityCase c = OppositeRotationsText();
  BoundBothWays bound(PaintedAvatar(head.head, kTurned, 0));
  const auto turn_to = [&](int degrees) {
    FlameParams params = Grimace();
    params.pose[0][1] = float(degrees * kDegree);
    bound.Pose(head.Vertices(params));
  };
  turn_to(0);
  double worst_sum = 0;
  int worst = 0;
  for (int degrees = 1; degrees <= 360; ++degrees) {
    const Buffer<float> last[2] = {bound.naive.posed.frame, bound.ours.posed.frame};
    turn_to(degrees);
    const Buffer<float>* now[2] = {&bound.naive.posed.frame, &bound.ours.posed.frame};
    StabilityForm* forms[2] = {&c.naive, &c.ours};
    for (int k : {0, 1}) {
      const double turn = LargestTurn(*now[k], last[k]);
      c.chart.curves[k].points.push_back({double(degrees), turn});
      forms[k]->value = std::max(forms[k]->value, turn);
    }
    double sum = 0;
    for (size_t i = 0; i < kTurned; ++i) sum += TurnOf(*now[0], *now[1], i);
    if (sum > worst_sum) worst = degrees;
    worst_sum = std::max(sum, worst_sum);
  }
  turn_to(worst);
  bound.naive.posed.scale_log = bound.ours.posed.scale_log;  // scale is a separate case
  const Camera camera = StudyCamera(float(worst * kDegree));
  c.naive.image = ImageOfTurns(bound.naive, bound.ours.posed.frame, camera);
  c.ours.image = ImageOfTurns(bound.ours, bound.ours.posed.frame, camera);
  return c;
}

StabilityCase CollapsedFacesCase(const StudyHead& head) {
  StabilityCase c;
  c.key = "collapsed_faces";
  c.title = "Collapsed and mirrored triangles";
  c.what =
      "Vertices around a corner of the mouth are mirrored, brought to one point, and put back. "
      "Gaussians (red) must stay numbers, and within their offset of their triangle.";
  c.quantity = "Gaussians astray, recovery to the bit";
  c.naive.name = "Normals divided by their length";
  c.ours.name = "No normal where there is none";
  const AvatarModel avatar = OffTheSurface(head.avatar);
  BoundBothWays bound(avatar);
  const BoundBothWays::Way rest = bound.ours;
  const std::vector<float>& start = avatar.mesh.vertices;
  for (const auto& vertices : {start, Spoiled(start, true), Spoiled(start, false), start}) {
    bound.Pose(vertices);
    const auto naive = Astray(avatar, vertices, UnguardedPositions(avatar, vertices));
    const auto ours = Astray(avatar, vertices, bound.ours.posed.position);
    const auto count = std::count(naive.begin(), naive.end(), true);
    if (double(count) > c.naive.value) {
      c.naive.image = ImageOfAstray(rest, naive);
      c.ours.image = ImageOfAstray(rest, ours);
    }
    c.naive.value = std::max(c.naive.value, double(count));
    c.ours.value = std::max(c.ours.value, double(std::count(ours.begin(), ours.end(), true)));
  }
  // Recovery must be bit-exact.
  if (bound.ours.posed.position != rest.posed.position) c.ours.value = INFINITY;
  return c;
}

}  // namespace cosplat

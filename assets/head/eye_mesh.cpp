#include <algorithm>
#include <cmath>

#include "assets/head/mesh_builder.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

constexpr int kEyeballColumns = 24;
constexpr int kEyeballRows = 12;
constexpr float kCorneaHeight = 0.0005f;
constexpr float kCorneaAngle = 26;  // degrees from the optical axis

// Almond shape: pointed at the corners, highest slightly off the middle.
float Almond(float along, float skew) {
  const float t = std::clamp(along + skew * (1 - along * along), -1.0f, 1.0f);
  return std::pow(std::max(1 - t * t, 0.0f), 0.78f);
}
float CornerElevation(float along) { return -2.5f + 5.0f * (0.5f + 0.5f * along); }

struct LidParameter {
  float along, upper;
};
// Parameter of vertex k of n in a loop around an eye.
LidParameter ParameterOf(size_t k, size_t n, bool left) {
  const float half = n / 2.0f;
  const bool lower = k < n / 2;
  const float turn = lower ? k / half : 2 - k / half;  // 0 at the -x corner, 1 at the +x corner
  const float t = 0.6f * -std::cos(turn * 180 * kDegree) + 0.4f * (2 * turn - 1);
  const bool corner = k == 0 || k == n / 2;
  return {left ? t : -t, corner ? 0.0f : lower ? -1.0f : 1.0f};
}

float LidElevation(const LidParameter& p) {
  return p.upper >= 0 ? UpperLidElevation(p.along) : LowerLidElevation(p.along);
}

}  // namespace

float LidAzimuth(float along) { return -3 + 65 * along; }
float UpperLidElevation(float along) {
  return CornerElevation(along) + 20.5f * Almond(along, 0.10f);
}
float LowerLidElevation(float along) { return CornerElevation(along) - 17 * Almond(along, -0.08f); }
float ClosedLidElevation(float along) { return CornerElevation(along) - 12.5f * Almond(along, 0); }

Vec EyeCenter(bool left) { return {left ? kEyeX : -kEyeX, kEyeY, kEyeZ}; }

Vec AroundEye(bool left, float azimuth, float elevation, float radius) {
  const float a = azimuth * kDegree, e = elevation * kDegree;
  const Vec d{
      (left ? 1.0f : -1.0f) * std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)};
  return EyeCenter(left) + radius * d;
}

EyeAngles AnglesAroundEye(bool left, const Vec& p) {
  const Vec q = p - EyeCenter(left);
  const float radius = std::max(Length(q), 1e-9f);
  return {std::atan2(left ? q.x : -q.x, q.z) / kDegree,
          std::asin(std::clamp(q.y / radius, -1.0f, 1.0f)) / kDegree,
          radius};
}

void AddEye(MeshBuilder& builder, const std::vector<int>& loop, bool left) {
  const size_t n = loop.size();
  std::vector<LidParameter> parameters;
  std::vector<Vec> edge;
  for (size_t k = 0; k < n; ++k) {
    const LidParameter p = ParameterOf(k, n, left);
    parameters.push_back(p);
    edge.push_back(
        AroundEye(left, LidAzimuth(p.along), LidElevation(p), kLidOuterRadius - 0.0003f));
  }
  auto label = [&](size_t k, int ring, Part part) {
    VertexLabel l;
    l.part = part;
    l.lid_ring = ring;
    l.along = parameters[k].along;
    l.upper = parameters[k].upper;
    return l;
  };
  const auto skin = builder.AddSkinRings(loop, edge, kSkinRings);
  for (int r = 0; r < kSkinRings; ++r)
    for (size_t k = 0; k < n; ++k)
      builder.mesh.labels[skin[r][k]] = label(k, kSkinRings - r, Part::kSkin);
  std::vector<int> previous = skin.back(), ring(n);
  // The lid's edge, then the pocket behind the eyeball: share of the way to the eyeball's back
  // pole.
  static constexpr float kTowardsBack[] = {0, 0, 0.20f, 0.45f, 0.68f, 0.86f};
  for (int r = 0; r < 6; ++r) {
    for (size_t k = 0; k < n; ++k) {
      const float radius = r == 0 ? kLidOuterRadius - 0.0003f : kLidInnerRadius;
      Vec d = Normalize(edge[k] - EyeCenter(left));
      const Vec sideways = Normalize(Vec{d.x, d.y, 0});
      const float from = std::acos(std::clamp(d.z, -1.0f, 1.0f));
      const float to = from + kTowardsBack[r] * (180 * kDegree - from);
      d = sideways * std::sin(to) + Vec{0, 0, std::cos(to)};
      ring[k] = builder.AddVertex(
          EyeCenter(left) + radius * d, label(k, -r, r == 0 ? Part::kSkin : Part::kSocket), false);
    }
    builder.JoinLoops(previous, ring);
    if (r == 0) builder.mesh.lid_loops[left ? 0 : 1] = ring;
    previous = ring;
  }
  const int back = builder.AddVertex(
      EyeCenter(left) - Vec{0, 0, kLidInnerRadius}, label(0, -6, Part::kSocket), false);
  builder.CloseLoop(previous, back);
}

void AddEyeball(MeshBuilder& builder, bool left) {
  VertexLabel label;
  label.part = left ? Part::kLeftEye : Part::kRightEye;
  const Vec center = EyeCenter(left);
  auto radius_at = [](float degrees) {
    return kEyeRadius +
           kCorneaHeight * (1 - SmoothStep(0.35f * kCorneaAngle, kCorneaAngle, degrees));
  };
  const int front = builder.AddVertex(center + Vec{0, 0, radius_at(0)}, label, false);
  std::vector<int> previous(kEyeballColumns, front), ring(kEyeballColumns);
  for (int r = 1; r < kEyeballRows; ++r) {
    // Denser towards the cornea.
    const float s = float(r) / kEyeballRows;
    const float polar = 180 * (0.55f * s + 0.45f * s * s);
    for (int k = 0; k < kEyeballColumns; ++k) {
      const float around = 360.0f * k / kEyeballColumns * kDegree;
      const float p = polar * kDegree;
      const Vec d{std::cos(around) * std::sin(p), std::sin(around) * std::sin(p), std::cos(p)};
      ring[k] = builder.AddVertex(center + radius_at(polar) * d, label, false);
    }
    if (r == 1) {
      builder.CloseLoop(ring, front);
    } else {
      builder.JoinLoops(ring, previous);
    }
    previous = ring;
  }
  const int back = builder.AddVertex(center - Vec{0, 0, kEyeRadius}, label, false);
  std::reverse(previous.begin(), previous.end());
  builder.CloseLoop(previous, back);
}

}  // namespace cosplat::procedural

// The expression directions: smooth fields around mouth, cheeks, nose and brows, and lids that
// rotate about the eyeball.

#include <algorithm>
#include <cmath>

#include "assets/head/procedural_head.h"
#include "assets/head/rig.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

struct Site {
  Vec p{};
  VertexLabel l;
  float side;  // relative to the mouth's line: 1 above, -1 below, smooth on unlabelled skin
  float lip;   // 1 on skin and lips, fading to 0 at the gums
};

Site SiteOf(const HeadMesh& mesh, int v) {
  Site s{mesh.positions[v], mesh.labels[v], 0, 1};
  s.side = s.l.mouth_ring != kNoRing ? s.l.upper : std::tanh((s.p.y - kMouthY) / 0.006f);
  if (s.l.mouth_ring >= kVestibule) s.lip = s.l.mouth_ring == kVestibule ? 0.6f : 0.0f;
  return s;
}

// 1 along the lips, falling off above and below: for fields that move the mouth.
float AtMouth(const Site& s, float half_width, float height) {
  return s.lip * Bell(s.p.x, half_width) * Bell(s.p.y - kMouthY, height) *
         SmoothStep(0.0f, 0.03f, s.p.z);
}
// Fades out from the middle of the mouth to its corners.
float Middle(const Site& s) {
  const float t = s.p.x / kMouthHalfWidth;
  return std::exp(-1.6f * t * t * t * t);
}

Vec Smile(const Site& s, float sign) {
  const float corner = s.lip * Ball(s.p, {sign * 0.0265f, kMouthY, 0.0530f}, 0.0175f);
  const float cheek = Ball(s.p, {sign * 0.0400f, -0.008f, 0.0470f}, 0.0180f) * (1 - NearEye(s.p));
  return corner * Vec{sign * 0.0050f, 0.0052f, -0.0036f} +
         cheek * Vec{sign * 0.0012f, 0.0030f, 0.0022f};
}

Vec Frown(const Site& s) {
  const Vec c{std::abs(s.p.x), s.p.y, s.p.z};
  const float corner = s.lip * Ball(c, {0.0265f, kMouthY, 0.0530f}, 0.0150f);
  return corner * Vec{s.p.x > 0 ? 0.0006f : -0.0006f, -0.0050f, -0.0006f};
}

Vec Pucker(const Site& s) {
  const float g = AtMouth(s, 0.042f, 0.018f);
  return g * Vec{-0.42f * s.p.x, 0, 0.0030f + 0.0046f * SmoothStep(0, 0.026f, std::abs(s.p.x))};
}

Vec Funnel(const Site& s) {
  const float g = AtMouth(s, 0.040f, 0.017f);
  return g * Vec{-0.24f * s.p.x, s.side * 0.0034f * Middle(s), 0.0034f};
}

Vec LipsApart(const Site& s) {
  const float g = AtMouth(s, 0.045f, 0.017f) * Middle(s);
  return g * Vec{0, s.side > 0 ? 0.0028f * s.side : 0.0042f * s.side, -0.0004f};
}

Vec LipPress(const Site& s) {
  const float g = AtMouth(s, 0.045f, 0.013f);
  const float lips = s.l.mouth_ring >= kVermilion ? 1.0f : 0.5f;
  return g * Vec{0, -0.45f * (s.p.y - kMouthY), -0.0016f * lips};
}

Vec MouthShift(const Site& s) {
  const float g = s.lip * Ball(s.p, {0, kMouthY, 0.058f}, 0.034f);
  return g * Vec{0.0060f, 0, -0.12f * s.p.x};
}

float AtBrow(const Vec& p) {
  return Bell(p.y - 0.058f, 0.022f) * SmoothStep(0.072f, 0.045f, std::abs(p.x)) *
         SmoothStep(0.0f, 0.03f, p.z) * (1 - 0.9f * NearEye(p));
}

Vec BrowUp(const Site& s) { return AtBrow(s.p) * Vec{0, 0.0062f, -0.0006f}; }
Vec InnerBrowUp(const Site& s) {
  return AtBrow(s.p) * Bell(s.p.x, 0.024f) * Vec{0, 0.0068f, 0.0004f};
}
Vec BrowKnit(const Site& s) {
  const float g = AtBrow(s.p) * Bell(std::abs(s.p.x) - 0.014f, 0.020f);
  return g * Vec{-0.22f * s.p.x, -0.0042f, 0.0016f};
}

// Rotates a lid's vertex by `degrees` of elevation; rings away from the edge follow partially.
Vec TurnLid(const Site& s, bool left, float degrees) {
  static constexpr float kBehind[] = {0.84f, 0.5f, 0.2f, 0, 0};  // rings -2 to -6
  static constexpr float kSkin[] = {0.62f, 0.16f, 0};            // rings 1 to 3
  const int ring = s.l.lid_ring;
  const float follow = ring > 0 ? kSkin[ring - 1] : ring >= -1 ? 1.0f : kBehind[-2 - ring];
  const EyeAngles a = AnglesAroundEye(left, s.p);
  // Rotates about the horizontal axis through the eyeball, so that the path stays on a sphere.
  const Vec center = EyeCenter(left);
  const float e = follow * degrees * 0.01745329f;
  Vec d = s.p - center;
  d = {d.x, d.y * std::cos(e) + d.z * std::sin(e), -d.y * std::sin(e) + d.z * std::cos(e)};
  const float min = ring >= 0 ? kLidOuterRadius - 0.0003f : a.radius;
  const float radius = std::max(Length(d), min);
  return center + Normalize(d) * radius - s.p;
}

// Rotation about the horizontal axis that takes elevation `from` to `to` at this azimuth.
float TurnBetween(float azimuth, float from, float to) {
  const float c = std::cos(azimuth * 0.01745329f);
  auto pitch = [&](float elevation) { return std::atan2(std::tan(elevation * 0.01745329f), c); };
  return (pitch(to) - pitch(from)) * 57.29578f;
}

Vec Lids(const Site& s, bool left, bool blink, float upper, float lower) {
  if (s.l.lid_ring == kNoRing || (s.p.x > 0) != left || s.l.upper == 0) return {};
  const float t = s.l.along, azimuth = LidAzimuth(t);
  if (!blink) return TurnLid(s, left, (s.l.upper > 0 ? upper : lower) * (1 - t * t));
  const float closed = ClosedLidElevation(t);
  const float overlap = 1.2f * (1 - t * t);
  return s.l.upper > 0
             ? TurnLid(s, left, TurnBetween(azimuth, UpperLidElevation(t), closed - overlap))
             : TurnLid(s, left, TurnBetween(azimuth, LowerLidElevation(t), closed));
}

Vec CheekPuff(const Site& s) {
  const float sign = s.p.x > 0 ? 1.0f : -1.0f;
  const float g =
      s.lip * Ball({std::abs(s.p.x), s.p.y, s.p.z}, {0.040f, -0.034f, 0.0380f}, 0.0200f);
  return g * Vec{sign * 0.0062f, 0, 0.0034f};
}

Vec Sneer(const Site& s) {
  const Vec m{std::abs(s.p.x), s.p.y, s.p.z};
  const float wing = Ball(m, {0.0130f, -0.012f, 0.0660f}, 0.0120f);
  const float lip = s.side > 0 ? AtMouth(s, 0.028f, 0.014f) * s.side : 0.0f;
  return wing * Vec{s.p.x * 0.05f, 0.0030f, 0.0002f} + lip * Vec{0, 0.0024f, 0.0004f};
}

Vec ChinRaise(const Site& s) {
  const float chin = Ball(s.p, {0, -0.062f, 0.0600f}, 0.0180f);
  const float lip = s.side < 0 ? -s.side * AtMouth(s, 0.030f, 0.012f) : 0.0f;
  return chin * Vec{0, 0.0032f, 0.0008f} + lip * Vec{0, 0.0004f, 0.0022f};
}

}  // namespace

Vec LidShift(const HeadMesh& mesh, int v, bool left, float upper, float lower) {
  return Lids(SiteOf(mesh, v), left, false, upper, lower);
}

Vec ExpressionShift(const HeadMesh& mesh, int expression, int v) {
  const Site s = SiteOf(mesh, v);
  if (s.l.part == Part::kLeftEye || s.l.part == Part::kRightEye) return {};
  switch (Expression(expression)) {
    case Expression::kSmileLeft:
      return Smile(s, 1);
    case Expression::kSmileRight:
      return Smile(s, -1);
    case Expression::kFrown:
      return Frown(s);
    case Expression::kPucker:
      return Pucker(s);
    case Expression::kFunnel:
      return Funnel(s);
    case Expression::kLipsApart:
      return LipsApart(s);
    case Expression::kLipPress:
      return LipPress(s);
    case Expression::kMouthShift:
      return MouthShift(s);
    case Expression::kBrowUp:
      return BrowUp(s);
    case Expression::kInnerBrowUp:
      return InnerBrowUp(s);
    case Expression::kBrowKnit:
      return BrowKnit(s);
    case Expression::kBlinkLeft:
      return Lids(s, true, true, 0, 0);
    case Expression::kBlinkRight:
      return Lids(s, false, true, 0, 0);
    case Expression::kSquint:
      return Lids(s, s.p.x > 0, false, -4, 7);
    case Expression::kWideEyes:
      return Lids(s, s.p.x > 0, false, 8, -2);
    case Expression::kCheekPuff:
      return CheekPuff(s);
    case Expression::kSneer:
      return Sneer(s);
    case Expression::kChinRaise:
      return ChinRaise(s);
    case Expression::kCount:
      break;
  }
  return {};
}

std::vector<float> ExpressionDirections(const HeadMesh& mesh) {
  std::vector<float> directions;
  directions.reserve(size_t(kExpressionCount) * mesh.positions.size() * 3);
  for (int e = 0; e < kExpressionCount; ++e)
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec d = ExpressionShift(mesh, e, int(v));
      directions.insert(directions.end(), {d.x, d.y, d.z});
    }
  return directions;
}

}  // namespace cosplat::procedural

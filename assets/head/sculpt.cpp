#include "assets/head/sculpt.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cosplat::procedural {
namespace {

// Polynomial smooth minimum of two distances, blended over a band of width k.
float Join(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - h * h * k * 0.25f;
}
float Carve(float a, float b, float k) { return -Join(-a, b, k); }

float Ellipsoid(const Vec& p, const Vec& center, const Vec& radii) {
  const Vec q = p - center;
  const float k0 = Length(q / radii);
  const float k1 = Length(q / (radii * radii));
  return k1 < 1e-9f ? -radii.x : k0 * (k0 - 1) / k1;
}

// A capsule whose radius varies from ra at a to rb at b.
float Cone(const Vec& p, const Vec& a, const Vec& b, float ra, float rb) {
  const Vec ab = b - a;
  const float t = std::clamp(Dot(p - a, ab) / Dot(ab, ab), 0.0f, 1.0f);
  return Length(p - a - t * ab) - (ra + t * (rb - ra));
}

// Mirrors x to the subject's left, without a crease at the median plane.
Vec Mirrored(const Vec& p, float softness) {
  return {std::sqrt(p.x * p.x + softness * softness), p.y, p.z};
}

float Skull(const Vec& p, const Vec& m) {
  float d = Ellipsoid(p, {0, 0.052f, -0.036f}, {0.0745f, 0.0885f, 0.0955f});
  d = Join(d, Ellipsoid(p, {0, 0.062f, 0.002f}, {0.0600f, 0.056f, 0.0600f}), 0.030f);  // forehead
  d = Join(d, Ellipsoid(p, {0, -0.010f, 0.002f}, {0.0590f, 0.068f, 0.0560f}), 0.028f);
  // Jaw: from its angle below the ear to the chin.
  d = Join(d,
           Cone(m, {0.0460f, -0.040f, -0.012f}, {0.0160f, -0.0690f, 0.0400f}, 0.0100f, 0.0115f),
           0.034f);
  d = Join(d, Ellipsoid(m, {0.0060f, -0.0695f, 0.0440f}, {0.0150f, 0.0145f, 0.0155f}), 0.016f);
  // The floor of the mouth, between the two sides of the jaw.
  d = Join(d, Ellipsoid(p, {0, -0.0560f, 0.0120f}, {0.0380f, 0.0290f, 0.0400f}), 0.020f);
  // Cheek bones and the flesh below them.
  d = Join(d, Ellipsoid(m, {0.0475f, 0.006f, 0.0230f}, {0.0175f, 0.0130f, 0.0190f}), 0.026f);
  d = Join(d, Ellipsoid(m, {0.0300f, -0.016f, 0.0370f}, {0.0200f, 0.0240f, 0.0180f}), 0.024f);
  return d;
}

float BrowsAndSockets(float d, const Vec& m) {
  d = Join(d,
           Cone(m, {0.010f, 0.0490f, 0.0500f}, {0.0440f, 0.0520f, 0.0360f}, 0.0090f, 0.0085f),
           0.016f);
  d = Carve(d, Ellipsoid(m, {0.0320f, 0.0310f, 0.0640f}, {0.0205f, 0.0125f, 0.0135f}), 0.014f);
  d = Carve(d, Ellipsoid(m, {0.0165f, 0.0330f, 0.0640f}, {0.0070f, 0.0090f, 0.0110f}), 0.012f);
  return d;
}

float Lids(float d, const Vec& m) {
  const float ball = Length(m - Vec{kEyeX, kEyeY, kEyeZ}) - kLidOuterRadius;
  return Join(d, ball, 0.0055f);
}

float Nose(float d, const Vec& p, const Vec& m) {
  d = Join(d, Cone(p, {0, 0.0320f, 0.0500f}, {0, -0.0050f, 0.0735f}, 0.0075f, 0.0078f), 0.013f);
  d = Join(d, Ellipsoid(p, {0, -0.0092f, 0.0765f}, {0.0090f, 0.0084f, 0.0090f}), 0.008f);
  d = Join(d, Ellipsoid(m, {0.0122f, -0.0128f, 0.0665f}, {0.0062f, 0.0066f, 0.0085f}), 0.0060f);
  d = Join(d, Cone(p, {0, -0.0150f, 0.0760f}, {0, -0.0195f, 0.0640f}, 0.0034f, 0.0040f), 0.006f);
  // Nostrils, open downwards; the crease behind the wings.
  d = Carve(d, Ellipsoid(m, {0.0072f, -0.0200f, 0.0705f}, {0.0032f, 0.0046f, 0.0050f}), 0.003f);
  d = Carve(d, Ellipsoid(m, {0.0200f, -0.0120f, 0.0640f}, {0.0022f, 0.0065f, 0.0045f}), 0.006f);
  return d;
}

float Mouth(float d, const Vec& p, const Vec& m) {
  d = Join(d, Ellipsoid(p, {0, -0.0390f, 0.0360f}, {0.0310f, 0.0270f, 0.0270f}), 0.020f);
  d = Carve(d, Cone(p, {0, -0.0205f, 0.0725f}, {0, -0.0310f, 0.0705f}, 0.0042f, 0.0042f), 0.006f);
  // Fold between lower lip and chin, and the fold from the nose to the corner of the mouth.
  d = Carve(d, Ellipsoid(p, {0, -0.0555f, 0.0720f}, {0.0210f, 0.0050f, 0.0120f}), 0.012f);
  d = Carve(d,
            Cone(m, {0.0195f, -0.0140f, 0.0700f}, {0.0345f, -0.0440f, 0.0580f}, 0.0040f, 0.0050f),
            0.012f);
  return d;
}

float NeckAndShoulders(float d, const Vec& p, const Vec& m) {
  const Vec flat{p.x, p.y, p.z * 0.96f};
  float body = Cone(flat, {0, -0.030f, -0.048f}, {0, -0.160f, -0.058f}, 0.0500f, 0.0545f);
  body = Join(
      body, Cone(m, {0.050f, -0.028f, -0.045f}, {0.012f, -0.150f, -0.012f}, .010f, .010f), 0.020f);
  body = Join(body, Ellipsoid(p, {0, -0.108f, -0.0070f}, {0.014f, 0.016f, 0.011f}), 0.024f);
  // Trapezius and shoulders, and the top of the chest.
  body = Join(
      body, Cone(m, {0.020f, -0.108f, -0.075f}, {0.096f, -0.182f, -0.062f}, .026f, .036f), 0.045f);
  body = Join(body, Ellipsoid(p, {0, -0.196f, -0.050f}, {0.104f, 0.050f, 0.068f}), 0.040f);
  return Join(d, body, 0.022f);
}

// Height of the hairline by the angle about the vertical axis, from the forehead via temple,
// sideburn and ear to the nape.
constexpr int kHairlinePoints = 14;
constexpr float kHairlineAngle[kHairlinePoints] = {
    0, 20, 34, 48, 58, 64, 68, 74, 80, 102, 109, 117, 138, 180};
constexpr float kHairlineHeight[kHairlinePoints] = {0.106f,
                                                    0.109f,
                                                    0.107f,
                                                    0.088f,
                                                    0.066f,
                                                    0.044f,
                                                    0.012f,
                                                    0.010f,
                                                    0.044f,
                                                    0.044f,
                                                    0.014f,
                                                    -0.022f,
                                                    -0.052f,
                                                    -0.060f};

}  // namespace

float SkinDistance(const Vec& p) {
  const Vec m = Mirrored(p, 0.0015f);
  float d = Skull(p, m);
  d = BrowsAndSockets(d, m);
  d = Nose(d, p, m);
  d = Mouth(d, p, m);
  d = Lids(d, m);
  return NeckAndShoulders(d, p, m);
}

float HairInside(const Vec& p) {
  const float angle = std::atan2(std::abs(p.x), p.z + 0.035f) * 57.29578f;
  int k = 0;
  while (k < kHairlinePoints - 2 && angle > kHairlineAngle[k + 1]) ++k;
  const float t = SmoothStep(kHairlineAngle[k], kHairlineAngle[k + 1], angle);
  const float edge = kHairlineHeight[k] + t * (kHairlineHeight[k + 1] - kHairlineHeight[k]);
  return p.y - edge;
}

float HeadDistance(const Vec& p) {
  const float skin = SkinDistance(p);
  if (p.y < -0.07f) return skin;
  const float top = SmoothStep(0.05f, 0.125f, p.y);
  const float side = 0.0050f + 0.0120f * top + 0.003f * SmoothStep(-0.05f, 0.05f, p.z) * top;
  const float inside = HairInside(p);
  const float wave = 1 + 0.10f * std::sin(70 * p.x + 55 * p.z) * std::sin(62 * p.z - 40 * p.x);
  // Swept back from the forehead: the hair rises slowly there and quickly at the nape.
  const float rise = 0.018f + 0.018f * SmoothStep(0, 0.05f, p.z);
  return skin - side * wave * SmoothStep(-0.004f, rise, inside);
}

Vec HeadGradient(const Vec& p) {
  constexpr float e = 3e-4f;
  Vec g{};
  for (int i = 0; i < 3; ++i) {
    Vec step{};
    step[i] = e;
    g[i] = (HeadDistance(p + step) - HeadDistance(p - step)) / (2 * e);
  }
  return g;
}

Vec ProjectToHead(Vec p) {
  for (int i = 0; i < 4; ++i) {
    const float d = HeadDistance(p);
    if (std::abs(d) < 2e-6f) break;
    const Vec g = HeadGradient(p);
    p = p - g * (d / std::max(Dot(g, g), 0.1f));
  }
  return p;
}

Vec CastOntoHead(const Vec& origin, const Vec& direction) {
  float s = 0.40f;
  for (int i = 0; i < 200 && s > 0; ++i) {
    const float d = HeadDistance(origin + direction * s);
    if (d < 1e-5f) break;
    s -= 0.6f * d;  // the joined distance is not exactly metric
  }
  return origin + direction * std::max(s, 0.0f);
}

float AmbientOcclusion(const Vec& p, const Vec& normal) {
  constexpr std::array<float, 4> kReach = {0.002f, 0.006f, 0.014f, 0.030f};
  float open = 1;
  for (float reach : kReach) {
    const float d = HeadDistance(p + normal * reach);
    open -= 0.22f * std::clamp(1 - d / reach, 0.0f, 1.5f);
  }
  return std::clamp(open, 0.0f, 1.0f);
}

}  // namespace cosplat::procedural

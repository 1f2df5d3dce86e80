#include <algorithm>
#include <cmath>

#include "assets/head/noise.h"
#include "assets/head/paint.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

constexpr Vec kSkin{0.600f, 0.345f, 0.240f};
constexpr Vec kLip{0.430f, 0.150f, 0.125f};

// Redness from blood under the skin: cheeks, nose, ears, chin, and around the nostrils.
float Redness(const Vec& m, float ear) {
  float r = 0.85f * Ball(m, {0.0430f, -0.008f, 0.0430f}, 0.0200f);
  r += 0.80f * Ball(m, {0, -0.010f, 0.0820f}, 0.0120f);
  r += 0.70f * Ball(m, {0.0140f, -0.014f, 0.0660f}, 0.0080f);
  r += 0.30f * Ball(m, {0, -0.070f, 0.0560f}, 0.0140f);
  if (ear >= 0) r += 0.75f;
  return r;
}

// A few dozen freckles: one candidate per cell of a jittered lattice.
float Freckles(const Vec& p, const Vec& m) {
  const float where =
      Ball(m, {0.0330f, 0.000f, 0.0500f}, 0.0240f) + Ball(m, {0, 0.010f, .072f}, .016f);
  if (where < 0.08f) return 0;
  constexpr float kCell = 0.0042f;
  const Vec q = p * (1 / kCell);
  const int x = int(std::floor(q.x)), y = int(std::floor(q.y)), z = int(std::floor(q.z));
  const Vec center{x + 0.25f + 0.5f * HashUnit(x, y, z), y + 0.25f + 0.5f * HashUnit(y, z, x), q.z};
  const float size = 0.10f + 0.13f * HashUnit(z, x, y);
  const float present = HashUnit(x + 17, y, z) < 0.5f * std::min(where, 1.0f) ? 1.0f : 0.0f;
  return present * (1 - SmoothStep(0.5f * size, 1.3f * size, Length(q - center)));
}

// Shaved beard: jaw, chin and upper lip.
float Beard(const Vec& p, const Vec& m, float mouth) {
  const float edge = -0.012f + 0.30f * std::max(0.0f, 0.045f - p.z);
  float area = SmoothStep(edge, edge - 0.022f, p.y) * SmoothStep(-0.030f, 0.005f, p.z);
  area *= SmoothStep(-0.112f, -0.090f, p.y - 0.2f * p.z);
  const float cheek = Ball(m, {0.0370f, -0.020f, 0.0420f}, 0.0150f);
  return area * (1 - 0.8f * cheek) * SmoothStep(-0.6f, -1.8f, mouth);
}

void PaintLips(const PaintSite& s, Material& m) {
  const float lip = SmoothStep(-0.45f, 0.30f, s.mouth);
  if (lip <= 0) return;
  const float lines = Noise2(s.along * 34, s.mouth * 0.9f, 0, 5);
  const float tone = Noise2(s.along * 5, s.mouth, 0, 6);
  const Vec color = kLip * (0.80f + 0.26f * lines + 0.22f * tone);
  const float touch = 1 - 0.75f * SmoothStep(1.7f, 2.6f, s.mouth);
  m.albedo = Mix(m.albedo, color * touch, lip);
  m.specular = Mix(m.specular, 0.34f * touch * (0.7f + 0.5f * lines), lip);
  m.shininess = Mix(m.shininess, 42, lip);
}

// The fold above the upper lid, at a smoothly varying height over its edge.
float Crease(const Vec& p) {
  const EyeAngles a = AnglesAroundEye(p.x > 0, p);
  const float along = (a.azimuth + 3) / 72;
  if (std::abs(along) >= 1 || a.radius > 0.03f) return 0;
  const float over = 1 - along * along;
  const float fold = UpperLidElevation(along) + 5 + 15 * std::sqrt(over);
  return Bell(a.elevation - fold, 3.4f) * SmoothStep(0.15f, 0.7f, over) *
         SmoothStep(-0.75f, -0.2f, along);
}

void PaintLids(const PaintSite& s, Material& m) {
  if (s.lid >= 3.9f) return;
  m.albedo = m.albedo * (1 - 0.36f * Crease(s.rest));
  const float near = SmoothStep(3.2f, 0.6f, s.lid);
  m.albedo = Mix(m.albedo, m.albedo * Vec{0.86f, 0.74f, 0.74f}, near);
  const float streak = Noise2(s.along * 30, 0, 0, s.upper > 0 ? 8 : 9);
  const float corner = 1 - 0.7f * std::pow(std::abs(s.along), 6.0f);
  if (s.upper > 0) {
    const float reach = 0.16f + 0.30f * streak * corner;
    const float lash = SmoothStep(reach, reach - 0.22f, s.lid) * SmoothStep(-0.95f, -0.5f, s.lid);
    m.albedo = Mix(m.albedo, Vec{0.018f, 0.012f, 0.010f}, 0.92f * lash);
  } else if (s.upper < 0) {
    const float reach = 0.02f + 0.26f * streak;
    const float lash = SmoothStep(reach, reach - 0.2f, s.lid) * SmoothStep(-0.55f, -0.2f, s.lid);
    m.albedo = Mix(m.albedo, Vec{0.05f, 0.03f, 0.025f}, 0.60f * lash * corner);
  }
  if (s.lid < -0.3f) {
    const float wet = SmoothStep(-0.3f, -0.7f, s.lid);
    m.albedo = Mix(m.albedo, Vec{0.42f, 0.19f, 0.16f}, (s.upper > 0 ? 0.3f : 0.9f) * wet);
    m.specular = Mix(m.specular, 0.3f, wet);
    m.shininess = Mix(m.shininess, 60, wet);
  }
}

}  // namespace

void PaintFace(const PaintSite& s, Material& m) {
  const Vec p = s.rest, mirror{std::abs(p.x), p.y, p.z};
  const float blotch = Noise(p * 95.0f + Vec{3, 7, 1});
  const float mottle = Noise(p * 330.0f + Vec{11, 5, 2});
  const float pores = Noise(p * 1050.0f);
  m.albedo = kSkin * (0.90f + 0.12f * blotch + 0.09f * mottle + 0.10f * pores);
  const float red = std::min(Redness(mirror, s.ear) * (0.75f + 0.5f * mottle), 1.2f);
  m.albedo = m.albedo * Mix(Vec{1, 1, 1}, Vec{0.99f, 0.72f, 0.70f}, red);
  const float under_eye = Ball(mirror, {0.0300f, 0.0140f, 0.0530f}, 0.0100f);
  m.albedo = m.albedo * Mix(Vec{1, 1, 1}, Vec{0.84f, 0.76f, 0.80f}, under_eye);
  m.albedo = m.albedo * Mix(Vec{1, 1, 1}, Vec{0.74f, 0.63f, 0.54f}, Freckles(p, mirror));
  const float beard = Beard(p, mirror, s.mouth);
  if (beard > 0) {
    const Vec turned{p.x + 0.6f * p.y, p.y - 0.6f * p.z, p.z + 0.6f * p.x};
    const float dots = SmoothStep(0.30f, 0.95f, Noise(turned * 640.0f));
    m.albedo = m.albedo * Mix(Vec{1, 1, 1}, Vec{0.78f, 0.80f, 0.86f}, beard);
    m.albedo = m.albedo * (1 - 0.24f * beard * dots);
  }
  const float nostril = Ball(mirror, {0.0068f, -0.0195f, 0.0700f}, 0.0046f);
  m.albedo = m.albedo * (1 - 0.93f * SmoothStep(0.30f, 0.75f, nostril));
  const float oily = Ball(p, {0, 0.078f, 0.060f}, 0.035f) + Ball(p, {0, 0.006f, 0.078f}, 0.022f) +
                     0.7f * Ball(mirror, {0.040f, 0.008f, 0.045f}, 0.018f);
  m.specular = (0.15f + 0.24f * std::min(oily, 1.0f)) * (0.7f + 0.6f * pores);
  m.shininess = 18 + 16 * std::min(oily, 1.0f);
  PaintLips(s, m);
  PaintLids(s, m);
}

void PaintBrow(const PaintSite& s, Material& m) {
  const Vec& p = s.rest;
  const float a = std::abs(p.x);
  if (a < 0.006f || a > 0.060f || p.y < 0.040f || p.y > 0.066f || p.z < 0.01f) return;
  const float t = (a - 0.0105f) / 0.0435f;  // 0 at the medial end, 1 at the tail
  const float arch = 0.0515f + 0.0062f * std::sin(2.15f * std::clamp(t, 0.0f, 1.0f)) -
                     0.0030f * std::max(t - 0.55f, 0.0f);
  const float half = Mix(0.0038f, 0.0010f, std::clamp(t * t, 0.0f, 1.0f));
  const float across = p.y - arch;
  // Strokes lean outwards: upright at the medial end, flat at the tail.
  const float lean = Mix(0.9f, 2.6f, std::clamp(t, 0.0f, 1.0f));
  const float stroke = Noise2((a - lean * across) * 1250, across * 130, 0, p.x > 0 ? 21 : 22);
  const float ragged = half * (0.72f + 0.75f * stroke);
  float cover = 1 - SmoothStep(0.55f * ragged, 1.15f * ragged, std::abs(across));
  cover *= SmoothStep(-0.10f, 0.06f, t + 0.08f * stroke) * SmoothStep(1.06f, 0.90f, t);
  m.albedo = Mix(m.albedo, Vec{0.052f, 0.031f, 0.020f} * (0.6f + 0.9f * stroke), 0.88f * cover);
  m.specular *= 1 - 0.7f * cover;
}

Material PaintMouthInside(const PaintSite& s) {
  Material m;
  const bool upper = s.upper >= 0;
  const float tooth_count = upper ? 7.0f : 8.0f;
  const float phase = s.along * tooth_count;
  const float between = std::abs(phase - std::round(phase));  // 0 at a gap, 1/2 mid-tooth
  const float gum_line = 5.35f - 0.35f * std::cos(between * 6.2831853f) * 0.5f;
  const float row = SmoothStep(0.90f, 0.74f, std::abs(s.along));  // ends before the corners
  const float tooth = row * SmoothStep(gum_line - 0.06f, gum_line + 0.06f, s.mouth) *
                      SmoothStep(7.2f, 6.9f, s.mouth);
  const float gap = SmoothStep(0.02f, 0.10f, between);
  const Vec enamel = Vec{0.74f, 0.69f, 0.56f} * (0.30f + 0.70f * gap);
  Vec flesh{0.36f, 0.110f, 0.100f};
  if (s.mouth > 6.8f && !upper)
    flesh = Vec{0.43f, 0.150f, 0.140f} * (0.8f + 0.4f * Noise(s.rest * 500.0f));
  m.albedo = Mix(flesh * (1 - 0.7f * s.along * s.along), enamel, tooth);
  m.specular = 0.20f * tooth + 0.05f * (1 - s.along * s.along);
  m.shininess = 60;
  return m;
}

Material PaintHead(const PaintSite& site) {
  Material m;
  if (site.mouth > 3.0f) return PaintMouthInside(site);
  PaintFace(site, m);
  PaintBrow(site, m);
  if (site.ear < 0.5f) PaintHair(site, m);
  PaintShirt(site, m);
  return m;
}

}  // namespace cosplat::procedural

// Scalp hair, the shirt, and the eyes.

#include <algorithm>
#include <cmath>

#include "assets/head/noise.h"
#include "assets/head/paint.h"

namespace cosplat::procedural {
namespace {

// Strands leave the crown in all directions and curl around it slightly, as in a whorl.
constexpr Vec kCrown{0.010f, 0.060f, -0.050f};
constexpr Vec kCrownUp{0.05f, 0.93f, -0.36f};

struct Strand {
  float around;  // revolutions about the crown, [0, 1)
  float down;    // radians from the crown
  Vec flow{};
};

Strand StrandAt(const Vec& p, const Vec& normal) {
  const Vec up = Normalize(kCrownUp), side = Normalize(Cross(up, Vec{0, 0, 1}));
  const Vec front = Cross(side, up);
  const Vec d = Normalize(p - kCrown);
  const float c = Dot(d, up);
  Strand s;
  s.down = std::acos(std::clamp(c, -1.0f, 1.0f));
  const float angle = std::atan2(Dot(d, side), Dot(d, front)) + 0.35f * s.down;
  s.around = angle * 0.15915494f;
  s.around -= std::floor(s.around);
  const Vec away = d * c - up;  // down the meridian
  s.flow = Normalize(away - normal * Dot(away, normal));
  return s;
}

}  // namespace

void PaintHair(const PaintSite& site, Material& m) {
  const Vec& p = site.rest;
  if (p.y < -0.08f) return;
  const float inside = HairInside(p);
  if (inside < -0.010f) return;
  Strand s = StrandAt(p, site.normal);
  const float bend = Noise(p * 55.0f);
  s.around += 0.020f * (bend - 0.5f);
  const float clump = Noise2(s.around * 70, s.down * 5 + 3 * bend, 70, 31);
  const float strand = Noise2(s.around * 260, s.down * 9, 260, 32);
  const float fine = Noise2(s.around * 620, s.down * 14, 620, 33);
  const float grain = 0.45f * strand + 0.55f * fine;
  const float ragged = inside + 0.0090f * (grain - 0.5f) + 0.004f * (clump - 0.5f);
  const float cover = SmoothStep(-0.0035f, 0.0045f, ragged);
  const float light = 0.25f + 0.9f * clump * grain + 0.55f * grain * grain;
  const Vec color =
      Mix(Vec{0.020f, 0.012f, 0.008f}, Vec{0.150f, 0.085f, 0.045f}, std::min(light, 1.3f));
  m.albedo = Mix(m.albedo, color, cover);
  m.specular = Mix(m.specular, 0.06f + 0.26f * grain * grain, cover);
  m.shininess = Mix(m.shininess, 22, cover);
  m.hair = cover;
  m.flow = s.flow;
}

void PaintShirt(const PaintSite& site, Material& m) {
  const Vec& p = site.rest;
  const float collar = -0.132f - 0.16f * (p.z + 0.055f);
  const float depth = collar - p.y;  // below the collar's upper edge
  if (depth < -0.004f) return;
  if (depth < 0) {  // shadow of the collar on the neck
    m.albedo = m.albedo * (1 - 0.45f * SmoothStep(-0.004f, 0, depth));
    return;
  }
  const float around = std::atan2(p.x, p.z + 0.055f);
  const float band = 1 - SmoothStep(0.0085f, 0.0095f, depth);
  const float rib = 0.5f + 0.5f * std::sin(around * 190);
  const float knit = Noise2(around * 260, p.y * 1100, 0, 41);
  const float fold = Noise(p * 60.0f);
  const Vec cloth = Vec{0.055f, 0.105f, 0.185f} * (0.70f + 0.40f * knit + 0.35f * fold);
  m.albedo =
      cloth * Mix(1.0f, 0.72f + 0.30f * rib, band) * (1 - 0.5f * Bell(depth - 0.0092f, 0.0010f));
  m.specular = 0.02f;
  m.shininess = 8;
  m.hair = 0;
}

Material PaintEye(const Vec& d, bool left) {
  Material m;
  const float polar = std::acos(std::clamp(d.z, -1.0f, 1.0f)) * 57.29578f;
  const float around = std::atan2(d.y, d.x);
  const float turn = around * 0.15915494f + 0.5f;
  constexpr float kIris = 24.5f, kPupil = 9.0f;
  const float vein_field = Noise2(around * 9 + 0.10f * polar, polar * 0.16f, 0, left ? 51 : 52);
  const float vein =
      SmoothStep(0.040f, 0.0f, std::abs(vein_field - 0.5f)) * SmoothStep(30, 62, polar);
  Vec white = Mix(Vec{0.78f, 0.74f, 0.70f}, Vec{0.70f, 0.50f, 0.45f}, SmoothStep(40, 80, polar));
  white = Mix(white, Vec{0.55f, 0.16f, 0.12f}, 0.40f * vein);
  const float fibre = 0.6f * Noise2(turn * 64, polar * 0.12f, 64, 53) +
                      0.4f * Noise2(turn * 24, polar * .3f, 24, 54);
  const float out = (polar - kPupil) / (kIris - kPupil);
  Vec iris =
      Mix(Vec{0.20f, 0.13f, 0.05f}, Vec{0.085f, 0.17f, 0.20f}, SmoothStep(0.05f, 0.50f, out));
  iris = iris * (0.45f + 1.15f * fibre) * (1 - 0.70f * SmoothStep(0.72f, 1.0f, out));
  iris = iris * SmoothStep(kPupil - 0.8f, kPupil + 0.8f, polar);
  m.albedo = Mix(iris, white, SmoothStep(kIris - 1.4f, kIris + 1.6f, polar));
  m.specular = 1.6f;
  m.shininess = 260;
  return m;
}

}  // namespace cosplat::procedural

// Lips and the inside of the mouth: rings from the border of the lips to the throat, one vertex
// loop each; the upper half of a ring belongs to the skull, the lower half to the jaw.

#include <algorithm>
#include <cmath>

#include "assets/head/mesh_builder.h"

namespace cosplat::procedural {
namespace {

struct LipParameter {
  float along, upper;
};
LipParameter ParameterOf(size_t k, size_t n) {
  const float half = n / 2.0f;
  const bool lower = k < n / 2;
  const float turn = lower ? k / half : 2 - k / half;
  const float t = 0.55f * -std::cos(turn * 3.14159265f) + 0.45f * (2 * turn - 1);
  return {t, k == 0 || k == n / 2 ? 0.0f : lower ? -1.0f : 1.0f};
}

// The line along which the closed lips meet.
float LineHeight(float t) {
  const float a = std::abs(t);
  return kMouthY - 0.0011f * Bell(t, 0.20f) + 0.0006f * Bell(a - 0.5f, 0.25f) + 0.0007f * a * a * a;
}
// Height of the red of the lips.
float UpperHeight(float t) {
  const float a = std::abs(t);
  const float bow = 0.0078f - 0.0014f * Bell(t, 0.10f) + 0.0006f * Bell(a - 0.22f, 0.12f);
  return 0.0005f + bow * std::pow(std::max(1 - std::pow(a, 1.7f), 0.0f), 0.8f);
}
float LowerHeight(float t) {
  return 0.0005f + 0.0096f * std::pow(std::max(1 - t * t, 0.0f), 0.75f);
}
float Fullness(float t) { return std::pow(std::max(1 - t * t, 0.0f), 0.6f); }

// Depth of the sculpted face in front of (x, y).
float FaceDepth(float x, float y) { return CastOntoHead({x, y, 0}, {0, 0, 1}).z; }

// The dental arch, seen from above.
Vec Arch(float t, float y) { return {0.0225f * t, y, 0.0525f - 0.0210f * t * t}; }

Vec LipPosition(int ring, float t, float upper) {
  const float line = LineHeight(t), full = Fullness(t);
  const float height = upper >= 0 ? UpperHeight(t) : LowerHeight(t);
  const float sign = upper >= 0 ? 1.0f : -1.0f;
  const float x = kMouthHalfWidth * t;
  const float gap = 0.00012f * upper;
  const float face = FaceDepth(x, line);
  switch (ring) {
    case kVermilion: {
      const float y = line + sign * height;
      return {x * 1.01f, y, FaceDepth(x, y) + 0.0004f * full};
    }
    case kLipMiddle:
      return {x * 0.995f,
              line + sign * 0.52f * height,
              FaceDepth(x, line + sign * 0.5f * height) + (upper >= 0 ? 0.0022f : 0.0030f) * full};
    case kLipFront:
      return {x * 0.975f, line + gap, face + (0.0007f * full - 0.0008f)};
    default:
      return {x * 0.93f, line + gap, face - 0.0045f};
  }
}

Vec InsidePosition(int ring, float t, float upper) {
  const float line = LineHeight(t);
  const float open = std::abs(upper) * std::pow(std::max(1 - t * t, 0.0f), 0.3f);
  const bool up = upper >= 0;
  const Vec lip = LipPosition(kLipBack, t, upper);
  const float back = up ? 0 : 0.0028f;  // the lower teeth are behind the upper ones
  switch (ring) {
    case kVestibule:
      return lip + Vec{0, (up ? 0.0075f : -0.0085f) * open, -0.0012f};
    case kGum:
      return Arch(t * 0.99f, line + (up ? 0.0075f : -0.0105f) * open) - Vec{0, 0, back};
    case kToothEdge:
      return Arch(t * 0.99f, line + (up ? -0.0016f : -0.0030f) * open) - Vec{0, 0, back + 0.0006f};
    case kToothBack:
      return Arch(t * 0.95f, line + (up ? -0.0010f : -0.0034f) * open) - Vec{0, 0, back + 0.0030f};
    case kPalate:
      return Arch(t * 0.72f, line + (up ? 0.0110f : -0.0060f) * open) - Vec{0, 0, 0.0160f};
    default:
      return Vec{0.0110f * t, line + (up ? 0.0080f : -0.0080f) * open, 0.0040f};
  }
}

}  // namespace

void AddMouth(MeshBuilder& builder, const std::vector<int>& loop) {
  const size_t n = loop.size();
  std::vector<LipParameter> parameters;
  std::vector<Vec> border;
  for (size_t k = 0; k < n; ++k) {
    parameters.push_back(ParameterOf(k, n));
    border.push_back(LipPosition(kVermilion, parameters[k].along, parameters[k].upper));
  }
  auto label = [&](size_t k, int ring) {
    VertexLabel l;
    l.part = ring > kLipBack ? Part::kMouth : Part::kSkin;
    l.mouth_ring = ring;
    l.along = parameters[k].along;
    l.upper = parameters[k].upper;
    return l;
  };
  const auto skin = builder.AddSkinRings(loop, border, kSkinRings);
  for (int r = 0; r < kSkinRings; ++r)
    for (size_t k = 0; k < n; ++k) builder.mesh.labels[skin[r][k]] = label(k, r - kSkinRings);
  std::vector<int> previous = skin.back(), ring(n);
  for (int r = kVermilion; r <= kThroat; ++r) {
    for (size_t k = 0; k < n; ++k) {
      const LipParameter& p = parameters[k];
      const Vec x = r == kVermilion ? border[k]
                    : r <= kLipBack ? LipPosition(r, p.along, p.upper)
                                    : InsidePosition(r, p.along, p.upper);
      ring[k] = builder.AddVertex(x, label(k, r), false);
    }
    builder.JoinLoops(previous, ring);
    if (r == kLipFront) builder.mesh.lip_loop = ring;
    previous = ring;
  }
  builder.mesh.throat_loop = previous;
}

}  // namespace cosplat::procedural

// An ear: rings that rise from the skull, turn over the helix and sink into the concha.

#include <cmath>

#include "flame/procedural/mesh_builder.h"

namespace cosplat::procedural {
namespace {

// The plane of the left ear: `back` runs towards the back of the head and away from it.
struct EarFrame {
  Vec center{0.0775f, 0.0135f, -0.0270f};
  Vec up = Normalized(Vec{0.05f, 0.97f, -0.24f});
  Vec back = Normalized(Vec{0.42f, -0.22f, -0.88f});
  Vec out = Normalized(Cross(up, -back));
};

// Outline of the ear in its plane, metres, by the angle from `back` towards `up`.
Vec Outline(const EarFrame& f, float angle, float share) {
  const float c = std::cos(angle), s = std::sin(angle);
  const float width = (0.0172f + 0.0022f * s) * (c < 0 ? 0.85f : 1.0f);
  const float height = s > 0 ? 0.0300f : 0.0330f - 0.0030f * std::abs(c);
  return share * (width * c * f.back + height * s * f.up);
}

struct RingShape {
  float share_back, share_front;    // of the outline, on the free and on the attached side
  float height_back, height_front;  // above the ear's plane
};
constexpr RingShape kRings[] = {
    {0.86f, 0.98f, -0.0060f, -0.0010f},  // behind the rim
    {1.00f, 1.00f, -0.0012f, 0.0004f},   // rim
    {0.95f, 0.93f, 0.0018f, 0.0010f},    // top of the helix
    {0.82f, 0.80f, 0.0010f, 0.0004f},
    {0.72f, 0.68f, -0.0024f, -0.0004f},  // scapha
    {0.56f, 0.52f, 0.0006f, 0.0010f},    // antihelix, tragus
    {0.38f, 0.36f, -0.0040f, -0.0030f},  // concha
};

}  // namespace

void AddEar(MeshBuilder& builder, const std::vector<int>& loop, bool left) {
  const EarFrame frame;
  const size_t n = loop.size();
  auto mirrored = [&](const Vec& p) { return left ? p : Vec{-p.x, p.y, p.z}; };
  // The loop starts at the middle of its -x side: the front for the left ear, the back for the
  // right.
  auto angle_of = [&](size_t k) {
    const float turn = 6.2831853f * k / n;
    return left ? 3.14159265f + turn : -turn;
  };
  auto at = [&](float angle, float share, float height) {
    return frame.center + Outline(frame, angle, share) + height * frame.out;
  };
  auto label = [](int ring) {
    VertexLabel l;
    l.part = Part::kEar;
    l.ear_ring = ring;
    return l;
  };
  std::vector<int> ring(n), previous = loop;
  for (size_t k = 0; k < n; ++k) {
    const float a = angle_of(k), free_side = SmoothStep(-0.5f, 0.7f, std::cos(a));
    const float share = 1.02f + free_side * (0.58f - 1.02f);
    const Vec root = ProjectToHead(at(a, share, -0.006f * free_side));
    ring[k] = builder.AddVertex(mirrored(root), label(0), false);
  }
  builder.JoinLoops(previous, ring);
  previous = ring;
  for (int r = 0; r < 7; ++r) {
    const RingShape& s = kRings[r];
    for (size_t k = 0; k < n; ++k) {
      const float a = angle_of(k), free_side = SmoothStep(-0.6f, 0.5f, std::cos(a));
      const float share = s.share_front + free_side * (s.share_back - s.share_front);
      const float height = s.height_front + free_side * (s.height_back - s.height_front);
      ring[k] = builder.AddVertex(mirrored(at(a, share, height)), label(r + 1), false);
    }
    builder.JoinLoops(previous, ring);
    previous = ring;
  }
  const int middle = builder.AddVertex(
      mirrored(frame.center - 0.0085f * frame.out + 0.003f * frame.up - 0.004f * frame.back),
      label(kEarRings),
      false);
  builder.CloseLoop(previous, middle);
}

}  // namespace cosplat::procedural

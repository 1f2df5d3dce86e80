// An ear: rings that rise from the skull, turn over the helix and sink into the concha.

#include <cmath>

#include "assets/head/mesh_builder.h"

namespace cosplat::procedural {
namespace {

// The plane of the left ear; `back` points towards the back of the head and away from it.
struct EarFrame {
  Vec up = Normalize(Vec{0.06f, 0.97f, -0.24f});
  Vec back = Normalize(Vec{0.40f, -0.20f, -0.90f});
  Vec out = Normalize(Cross(up, -back));
  Vec center = ProjectToHead({0.085f, 0.0120f, -0.0260f}) + 0.0045f * out;
};

// Outline of the ear in its plane, metres, by the angle from `back` towards `up`: broad at the top,
// with a narrow lobe at the bottom.
Vec Outline(const EarFrame& f, float angle, float share) {
  const float c = std::cos(angle), s = std::sin(angle);
  const float width = (c < 0 ? 0.0140f : 0.0178f) * (1 + 0.14f * s - 0.10f * s * s);
  const float height = s > 0 ? 0.0305f : 0.0320f;
  const float lean = s < 0 ? -0.0045f * s * s : 0.0f;  // the lobe hangs forward
  return share * ((width * c + lean) * f.back + height * s * f.up);
}

// A ring's share of the outline and its height above the ear's plane, metres, at three places.
struct RingShape {
  float share_back, height_back;    // free edge: helix, scapha, antihelix, concha
  float share_front, height_front;  // attached edge and tragus
  float share_lobe, height_lobe;
};
constexpr RingShape kRings[] = {
    {0.84f, -0.0060f, 1.00f, 0.0002f, 0.90f, -0.0030f},
    {1.00f, -0.0012f, 0.98f, 0.0006f, 1.00f, -0.0004f},
    {0.97f, 0.0018f, 0.94f, 0.0010f, 0.96f, 0.0014f},
    {0.87f, 0.0014f, 0.86f, 0.0014f, 0.88f, 0.0020f},
    {0.77f, -0.0018f, 0.74f, 0.0012f, 0.76f, 0.0016f},
    {0.58f, 0.0012f, 0.58f, -0.0018f, 0.60f, 0.0008f},
    {0.38f, -0.0045f, 0.36f, -0.0050f, 0.38f, -0.0030f},
};

struct Placed {
  float share, height;
};
Placed PointOn(const RingShape& r, float angle) {
  const float free_side = SmoothStep(-0.75f, 0.25f, std::cos(angle));
  const float lobe = SmoothStep(0.45f, 0.95f, -std::sin(angle));
  const float share = Mix(r.share_front, r.share_back, free_side);
  const float height = Mix(r.height_front, r.height_back, free_side);
  return {Mix(share, r.share_lobe, lobe), Mix(height, r.height_lobe, lobe)};
}

}  // namespace

void AddEar(MeshBuilder& builder, const std::vector<int>& loop, bool left) {
  const EarFrame frame;
  const size_t n = loop.size();
  auto mirrored = [&](const Vec& p) { return left ? p : Vec{-p.x, p.y, p.z}; };
  // The loop starts at the middle of its -x side: the front of the left ear, the back of the right
  // one.
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
    const float a = angle_of(k), free_side = SmoothStep(-0.75f, 0.6f, std::cos(a));
    const float lobe = SmoothStep(0.45f, 0.95f, -std::sin(a));
    const float share = Mix(Mix(1.02f, 0.62f, free_side), 0.74f, lobe);
    const Vec root = ProjectToHead(at(a, share, -0.006f * free_side));
    ring[k] = builder.AddVertex(mirrored(root), label(0), false);
  }
  builder.JoinLoops(previous, ring);
  previous = ring;
  for (int r = 0; r < 7; ++r) {
    for (size_t k = 0; k < n; ++k) {
      const float a = angle_of(k);
      const Placed placed = PointOn(kRings[r], a);
      ring[k] =
          builder.AddVertex(mirrored(at(a, placed.share, placed.height)), label(r + 1), false);
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

// Walking on triangles: parallel to edges, in a straight line, without termination.
#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/study/avatar_stability/cases.h"
#include "apps/study/avatar_stability/naive_walk.h"
#include "apps/study/avatar_stability/sketch.h"
#include "apps/study/avatar_stability/steps.h"
#include "avatar/surface/walk.h"

namespace cosplat {
namespace {

using math::Vec3;

constexpr int kForEver = 100000;  // rounds; Walk takes kMaxWalkCrossings at most

// n x n squares over the unit square, cut along their diagonals, with displaced inner vertices.
CanonicalMesh IrregularSheet(int n) {
  Rng rng{1};
  CanonicalMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      const float x = float(i) + (inner ? 0.5f * (rng.Uniform() - 0.5f) : 0.0f);
      const float y = float(j) + (inner ? 0.5f * (rng.Uniform() - 0.5f) : 0.0f);
      mesh.vertices.insert(mesh.vertices.end(), {x / float(n), y / float(n), 0});
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.faces.push_back({a, b, d});
      mesh.faces.push_back({a, d, c});
    }
  return mesh;
}

// The part [low, low + side]^2 of a sheet.
class SheetSketch {
 public:
  SheetSketch(const Surface& surface, float low, float side)
      : sketch_(kStudyImage, kStudyImage), low_(low), scale_(kStudyImage / side) {
    for (size_t f = 0; f < surface.faces().size(); ++f)
      for (int c = 0; c < 3; ++c)
        Line(CornerAt(surface, int(f), c), CornerAt(surface, int(f), (c + 1) % 3), kMeshLine);
  }
  void Line(const Vec3<float>& a, const Vec3<float>& b, const SketchColor& color, float width = 1) {
    sketch_.Line(X(a.x), X(a.y), X(b.x), X(b.y), color, width);
  }
  void Dot(const Vec3<float>& p, const SketchColor& color) {
    sketch_.Dot(X(p.x), X(p.y), 2.5f, color);
  }
  const Image8& image() const { return sketch_.image(); }

 private:
  float X(float x) const { return (x - low_) * scale_; }
  Sketch sketch_;
  float low_, scale_;
};

const std::array<std::array<float, 2>, 6> kAxisSteps{
    {{.5f, 0}, {-.5f, 0}, {0, .5f}, {0, -.5f}, {.5f, -.5f}, {-.5f, .5f}}};

// A point from which the step leaves its face but not the sheet.
SurfacePoint StartBeforeAnEdge(const Surface& surface, const std::array<float, 2>& step, Rng& rng) {
  for (;;) {
    SurfacePoint p{int32_t(rng.Below(surface.faces().size())), {rng.Uniform(), rng.Uniform()}};
    if (p.barycentric[0] + p.barycentric[1] > 1) continue;
    const float u = p.barycentric[0] + step[0], v = p.barycentric[1] + step[1];
    if (u >= 0 && v >= 0 && u + v <= 1) continue;
    const Vec3<float> at = PlaceOf(surface, p);
    if (std::min({at.x, at.y, 1 - at.x, 1 - at.y}) > 0.2f) return p;
  }
}

}  // namespace

StabilityCase ParallelEdgeCase() {
  constexpr int kSteps = 10000, kDrawn = 60;
  const Surface surface(IrregularSheet(14));
  SheetSketch naive_sketch(surface, 0.2f, 0.6f), our_sketch(surface, 0.2f, 0.6f);
  StabilityCase c;
  c.key = "walk_parallel_edge";
  c.title = "Steps parallel to an edge";
  c.what =
      "Half a triangle's step along one of its edges, out of the triangle: 10,000 of them on an "
      "irregular sheet. A walk that meets the lines of all three edges at once finds no crossing.";
  c.quantity = "steps that stay in their triangle";
  c.naive.name = "All three edges at once, as released";
  c.ours.name = "The edge that is crossed";
  Rng rng{2};
  for (int i = 0; i < kSteps; ++i) {
    const auto& [du, dv] = kAxisSteps[i % 6];
    const SurfacePoint start = StartBeforeAnEdge(surface, {du, dv}, rng);
    const SurfacePoint naive = WalkNaively(surface, start, du, dv, kForEver).point;
    const SurfacePoint ours = Walk(surface, start, du, dv).point;
    c.naive.value += naive.triangle == start.triangle;
    c.ours.value += ours.triangle == start.triangle;
    if (i >= kDrawn) continue;
    const Vec3<float> from = PlaceOf(surface, start);
    naive_sketch.Line(from, PlaceOf(surface, naive), kNaiveInk, 1.5f);
    naive_sketch.Dot(PlaceOf(surface, naive), kNaiveInk);
    our_sketch.Line(from, PlaceOf(surface, ours), kOursInk, 1.5f);
    our_sketch.Dot(PlaceOf(surface, ours), kOursInk);
  }
  c.naive.image = naive_sketch.image();
  c.ours.image = our_sketch.image();
  return c;
}

StabilityCase BentPathCase() {
  constexpr int kPaths = 24, kPieces = 60, kSquares = 14;
  constexpr float kLength = 0.4f;
  const Surface surface(IrregularSheet(kSquares));
  SheetSketch naive_sketch(surface, 0.05f, 0.9f), our_sketch(surface, 0.05f, 0.9f);
  StabilityCase c;
  c.key = "walk_bent";
  c.title = "A straight path across many triangles";
  c.what =
      "Paths of about six triangles' length from the middle of an irregular flat sheet in 24 "
      "directions. Taking two triangles beside an edge for a parallelogram bends them.";
  c.quantity = "largest distance from where a straight line ends, in lengths of the path";
  c.bound = 1e-3;
  c.naive.name = "By parallelogram, as released";
  c.ours.name = "Unfolded with true lengths";
  const SurfacePoint start{int32_t(surface.faces().size() / 2) + kSquares, {.3f, .3f}};
  const Vec3<float> from = PlaceOf(surface, start);
  for (int k = 0; k < kPaths; ++k) {
    const float angle = 6.2831853f * float(k) / kPaths;
    const Vec3<float> way = Vec3<float>{std::cos(angle), std::sin(angle), 0} * kLength;
    const auto [du, dv] = StepOn(surface, start.triangle, way);
    Vec3<float> last[2] = {from, from};
    for (int i = 1; i <= kPieces; ++i) {
      const float part = float(i) / kPieces;
      const auto naive = WalkNaively(surface, start, part * du, part * dv, kForEver);
      const Vec3<float> places[2] = {
          PlaceOf(surface, naive.point),
          PlaceOf(surface, Walk(surface, start, part * du, part * dv).point)};
      naive_sketch.Line(last[0], places[0], kNaiveInk, 1.5f);
      our_sketch.Line(last[1], places[1], kOursInk, 1.5f);
      std::copy_n(places, 2, last);
    }
    c.naive.value = std::max(c.naive.value, double(math::Length(last[0] - from - way) / kLength));
    c.ours.value = std::max(c.ours.value, double(math::Length(last[1] - from - way) / kLength));
  }
  c.naive.image = naive_sketch.image();
  c.ours.image = our_sketch.image();
  return c;
}

StabilityCase EndlessWalkCase(const StudyHead& head) {
  const Surface surface(head.avatar.mesh);
  StabilityCase c;
  c.key = "walk_endless";
  c.title = "Steps that are no numbers, or have no end";
  c.what =
      "NaN, infinities and 1e30 in either coordinate of a step on a closed eyeball: 24 steps, as "
      "one bad gradient makes them. A walk until the point is inside a triangle goes on for ever.";
  c.quantity = "steps that end nowhere within 100,000 rounds";
  c.naive.name = "Until it is inside";
  c.ours.name = "Refused, 256 rounds at most";
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const SurfacePoint start{int32_t(surface.faces().size()) - 1, {.25f, .5f}};
  for (const float bad : {nan, inf, -inf, 1e30f, -1e30f, 3e38f})
    for (const auto& [du, dv] : {std::pair{bad, 0.1f}, {0.1f, bad}, {bad, bad}, {bad, -bad}}) {
      const NaiveWalkResult naive = WalkNaively(surface, start, du, dv, kForEver);
      const WalkResult ours = Walk(surface, start, du, dv);
      const auto finite = [](const SurfacePoint& p) {
        return std::isfinite(p.barycentric[0]) && std::isfinite(p.barycentric[1]);
      };
      c.naive.value += !naive.ended || !finite(naive.point);
      c.ours.value += !finite(ours.point);
    }
  return c;
}

}  // namespace cosplat

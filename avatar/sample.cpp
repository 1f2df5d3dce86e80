#include "avatar/sample.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <string>
#include <unordered_set>

#include "splat/base/error.h"

namespace cosplat {
namespace {

using math::Vec3;
using Weights = std::array<double, 3>;

// Faces looked at around the start, at most, and how many without an improvement end the search: a
// split moves a Gaussian by a few of its own widths, a few triangles on FLAME.
constexpr size_t kMaxVisitedFaces = 512;
constexpr size_t kMaxFruitlessFaces = 48;
// Newton's method for P(b) + d n(b) = x converges quadratically; a handful suffices where it does.
constexpr int kNewtonSteps = 12;
// Moves to a neighbouring face during it.
constexpr int kMaxFaceChanges = 8;

struct Corner {
  Vec3<double> position;
  Vec3<double> normal;
};
using Triangle = std::array<Corner, 3>;

Vec3<double> ToDouble(const Vec3<float>& v) { return {v.x, v.y, v.z}; }

Triangle CanonicalTriangle(const Surface& surface, int32_t face) {
  Triangle t;
  for (int c = 0; c < 3; ++c) {
    const SurfaceVertex& v = surface.canonical()[surface.faces()[face][c]];
    t[c] = {ToDouble(v.position), ToDouble(v.normal)};
  }
  return t;
}

Vec3<double> PointAt(const Triangle& t, const Weights& b) {
  return t[0].position * b[0] + t[1].position * b[1] + t[2].position * b[2];
}
Vec3<double> NormalSum(const Triangle& t, const Weights& b) {
  return t[0].normal * b[0] + t[1].normal * b[1] + t[2].normal * b[2];
}

double Length2(const Vec3<double>& v) { return math::Dot(v, v); }

// Closest point to x on the segment from corner i to corner j.
Weights ClosestOnEdge(const Triangle& t, int i, int j, const Vec3<double>& x) {
  const Vec3<double> edge = t[j].position - t[i].position;
  const double length2 = Length2(edge);
  const double s =
      length2 > 0 ? std::clamp(math::Dot(x - t[i].position, edge) / length2, 0.0, 1.0) : 0.0;
  Weights b{};
  b[i] = 1 - s;
  b[j] = s;
  return b;
}

// Weights of the closest point to x: the foot on the plane if it lies inside, otherwise the closest
// of the three edges.
Weights ClosestOnTriangle(const Triangle& t, const Vec3<double>& x) {
  const Vec3<double> a = t[1].position - t[0].position, c = t[2].position - t[0].position;
  const Vec3<double> normal = math::Cross(a, c), to_x = x - t[0].position;
  const double n2 = Length2(normal);
  if (n2 > 0) {
    const double b1 = math::Dot(math::Cross(to_x, c), normal) / n2;
    const double b2 = math::Dot(math::Cross(a, to_x), normal) / n2;
    if (b1 >= 0 && b2 >= 0 && b1 + b2 <= 1) return {1 - b1 - b2, b1, b2};
  }
  Weights best{};
  double best_distance2 = INFINITY;
  for (int i = 0; i < 3; ++i) {
    const Weights b = ClosestOnEdge(t, i, (i + 1) % 3, x);
    const double distance2 = Length2(PointAt(t, b) - x);
    if (distance2 < best_distance2) {
      best_distance2 = distance2;
      best = b;
    }
  }
  return best;
}

struct Found {
  int32_t face;
  Weights at;
  double distance2;
};

Found ClosestOnFace(const Surface& surface, int32_t face, const Vec3<double>& x) {
  const Triangle t = CanonicalTriangle(surface, face);
  const Weights b = ClosestOnTriangle(t, x);
  return {face, b, Length2(PointAt(t, b) - x)};
}

// Closest point of the faces around `start`, nearest faces first; equal distances by face index.
Found ClosestPoint(const Surface& surface, int32_t start, const Vec3<double>& x) {
  const auto farther = [](const Found& a, const Found& b) {
    return a.distance2 != b.distance2 ? a.distance2 > b.distance2 : a.face > b.face;
  };
  std::priority_queue<Found, std::vector<Found>, decltype(farther)> open(farther);
  std::unordered_set<int32_t> seen{start};
  Found best = ClosestOnFace(surface, start, x);
  open.push(best);
  size_t fruitless = 0;
  const MeshTopology& topology = surface.topology();
  while (!open.empty() && seen.size() < kMaxVisitedFaces && fruitless < kMaxFruitlessFaces) {
    const Found next = open.top();
    open.pop();
    ++fruitless;
    if (next.distance2 < best.distance2) {
      best = next;
      fruitless = 0;
    }
    for (int32_t v : surface.faces()[next.face])
      for (int32_t k = topology.vertex_face_begin[v]; k < topology.vertex_face_begin[v + 1]; ++k)
        if (seen.insert(topology.vertex_faces[k]).second)
          open.push(ClosestOnFace(surface, topology.vertex_faces[k], x));
  }
  return best;
}

struct Candidate {
  int32_t face;
  Weights at;
  double d;
  double residual;
};

// The best that weights `b` (inside the triangle) allow: d by projection on their normal.
Candidate Projected(const Surface& surface, int32_t face, const Weights& b, const Vec3<double>& x) {
  const Triangle t = CanonicalTriangle(surface, face);
  const Vec3<double> p = PointAt(t, b), n = math::Normalize(NormalSum(t, b));
  const double d = math::Dot(x - p, n);
  return {face, b, d, std::sqrt(Length2(p + n * d - x))};
}

// Solves P + h N = x for (b_0, b_1, h) on the plane of one triangle, N the sum of weighted normals
// before it is normalised (the line is the same). False when the equations become singular.
bool SolveOnTriangle(const Triangle& t, const Vec3<double>& x, Weights& b) {
  const Vec3<double> n0 = math::Normalize(NormalSum(t, b));
  double h = math::Dot(x - PointAt(t, b), n0);
  const Vec3<double> p0 = t[0].position - t[2].position, p1 = t[1].position - t[2].position;
  const Vec3<double> m0 = t[0].normal - t[2].normal, m1 = t[1].normal - t[2].normal;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Vec3<double> n = NormalSum(t, b), error = x - PointAt(t, b) - n * h;
    const Vec3<double> c0 = p0 + m0 * h, c1 = p1 + m1 * h;
    const double det = math::Dot(math::Cross(c0, c1), n);
    if (!(std::abs(det) > 1e-12 * std::sqrt(Length2(c0) * Length2(c1)))) return false;
    const double s0 = math::Dot(math::Cross(error, c1), n) / det;
    const double s1 = math::Dot(math::Cross(c0, error), n) / det;
    b[0] += s0;
    b[1] += s1;
    b[2] -= s0 + s1;
    h += math::Dot(math::Cross(c0, c1), error) / det;
    if (std::abs(s0) + std::abs(s1) < 1e-12) break;
  }
  return std::isfinite(b[0] + b[1] + b[2] + h);
}

// Solves on a face; where the solution lies outside, goes on in the face across the edge it left
// by.
Candidate SolveNear(const Surface& surface, const Found& from, const Vec3<double>& x) {
  Candidate best = Projected(surface, from.face, KeepInsideTriangle(from.at), x);
  int32_t face = from.face;
  Weights b = from.at;
  for (int change = 0; change <= kMaxFaceChanges; ++change) {
    if (!SolveOnTriangle(CanonicalTriangle(surface, face), x, b)) break;
    const Candidate here = Projected(surface, face, KeepInsideTriangle(b), x);
    if (here.residual < best.residual) best = here;
    const int lowest = int(std::min_element(b.begin(), b.end()) - b.begin());
    if (b[lowest] >= 0) break;
    face = surface.topology().face_neighbors[face][(lowest + 1) % 3];
    if (face < 0) break;
    b = ClosestOnFace(surface, face, x).at;
  }
  return best;
}

// Osada et al. 2002, section 4.2.
std::array<float, 2> UniformOnTriangle(Rng& rng) {
  const double s = std::sqrt(double(rng.Uniform())), t = rng.Uniform();
  const Weights b = KeepInsideTriangle({1 - s, s * (1 - t), s * t});
  return {float(b[0]), float(b[1])};
}

}  // namespace

std::vector<SurfacePoint> SampleSurface(const CanonicalMesh& mesh, size_t n, Rng& rng) {
  std::vector<double> area_up_to;
  double total = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    total += FaceArea(mesh, f);
    area_up_to.push_back(total);
  }
  if (!(total > 0) || !std::isfinite(total))
    throw Error("canonical mesh", "area", "is " + std::to_string(total));
  std::vector<SurfacePoint> points(n);
  for (size_t i = 0; i < n; ++i) {
    const double target = (double(i) + rng.Uniform()) / double(n) * total;
    const auto face = std::upper_bound(area_up_to.begin(), area_up_to.end(), target);
    points[i].triangle =
        int32_t(std::min<ptrdiff_t>(face - area_up_to.begin(), ptrdiff_t(mesh.faces.size()) - 1));
    points[i].barycentric = UniformOnTriangle(rng);
  }
  return points;
}

std::vector<SurfacePoint> SampleFaces(const CanonicalMesh& mesh, size_t n, Rng& rng) {
  if (mesh.faces.empty()) throw Error("canonical mesh", "faces", "there are none");
  std::vector<SurfacePoint> points(n);
  for (SurfacePoint& point : points) {
    point.triangle = int32_t(rng.Below(mesh.faces.size()));
    point.barycentric = UniformOnTriangle(rng);
  }
  return points;
}

EmbeddedPoint Reembed(const Surface& surface, const std::array<float, 3>& point, int32_t start) {
  if (size_t(start) >= surface.faces().size())
    throw Error("embedding",
                "triangle",
                std::to_string(start) + " of " + std::to_string(surface.faces().size()));
  const Vec3<double> x{point[0], point[1], point[2]};
  if (!std::isfinite(x.x + x.y + x.z)) throw Error("embedding", "point", "is not finite");
  const Candidate c = SolveNear(surface, ClosestPoint(surface, start, x), x);
  return {{c.face, {float(c.at[0]), float(c.at[1])}}, float(c.d), float(c.residual)};
}

}  // namespace cosplat

#include "avatar/walk.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "avatar/parallel_for.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using Weights = std::array<double, 3>;
using math::Vec3;

// Edge i of a face (corner i to corner i + 1) with the corner opposite to it.
struct EdgeShape {
  double length;
  double foot;    // of the opposite corner, measured from corner i along the edge
  double height;  // of the opposite corner over the edge
  bool solid() const { return length > 0 && height > 0; }
};

Vec3<double> CanonicalCorner(const Surface& surface, int32_t face, int corner) {
  const auto& p = surface.canonical()[surface.faces()[face][corner]].position;
  return {p.x, p.y, p.z};
}

EdgeShape ShapeOf(const Surface& surface, int32_t face, int edge) {
  const Vec3<double> a = CanonicalCorner(surface, face, edge);
  const Vec3<double> ab = CanonicalCorner(surface, face, (edge + 1) % 3) - a;
  const Vec3<double> ac = CanonicalCorner(surface, face, (edge + 2) % 3) - a;
  const double length = std::sqrt(math::Dot(ab, ab));
  if (length == 0) return {0, 0, 0};
  const Vec3<double> area = math::Cross(ab, ac);
  return {length, math::Dot(ac, ab) / length, std::sqrt(math::Dot(area, area)) / length};
}

bool Finite(const Weights& w) {
  return std::isfinite(w[0]) && std::isfinite(w[1]) && std::isfinite(w[2]);
}

// A weight falls by 1 at most in each triangle of about the same size.
bool TooLong(const Weights& step) {
  return std::max({std::abs(step[0]), std::abs(step[1]), std::abs(step[2])}) > kMaxWalkCrossings;
}

struct Walker {
  int32_t face;
  Weights at;    // barycentrics
  Weights step;  // what is left of the step, as changes of the barycentrics; sums to zero

  // The corner that the path leaves behind when it goes out of the face, and at which fraction of
  // the step; -1 when the step ends inside.
  int ExitCorner(double& fraction) const {
    int corner = -1;
    fraction = 1;
    for (int i = 0; i < 3; ++i) {
      if (!(step[i] < 0) || !(at[i] < -step[i] * fraction)) continue;
      fraction = at[i] / -step[i];
      corner = i;
    }
    return corner;
  }

  void Advance(double fraction) {
    for (int i = 0; i < 3; ++i) {
      at[i] += fraction * step[i];
      step[i] *= 1 - fraction;
    }
  }

  // Length of the step along `edge`.
  double Along(int edge, const EdgeShape& shape) const {
    return step[(edge + 1) % 3] * shape.length + step[(edge + 2) % 3] * shape.foot;
  }

  // The step's part along the boundary edge is kept.
  void Slide(int edge, const EdgeShape& shape) {
    const double share = shape.length > 0 ? Along(edge, shape) / shape.length : 0;
    step[(edge + 1) % 3] = share;
    step[edge] = -share;
    step[(edge + 2) % 3] = 0;
    at = KeepInsideTriangle(at);
  }

  // Into the face across `edge`, unfolded into this one's plane: the step's parts along the edge
  // and across it are the same lengths there. A path that meets a vertex turns about it, face by
  // face, until it has gone half way round: straight on.
  void Cross(
      int edge, const EdgeShape& shape, int32_t next, int next_edge, const EdgeShape& shape2) {
    const double along = Along(edge, shape);
    const double across = -step[(edge + 2) % 3] * shape.height;
    const double a = at[(edge + 1) % 3], b = at[edge];
    const int end = (next_edge + 1) % 3, apex = (next_edge + 2) % 3;
    face = next;
    at[next_edge] = a;
    at[end] = b;
    at[apex] = 0;
    step[apex] = across / shape2.height;
    step[end] = (-along - step[apex] * shape2.foot) / shape2.length;
    step[next_edge] = -step[apex] - step[end];
  }
};

// Whether the walk ended within the bound; `met_boundary` says whether it met one.
bool Follow(const Surface& surface, Walker& walker, bool& met_boundary) {
  const MeshTopology& topology = surface.topology();
  bool slid_here = false;  // already along a boundary edge of this face
  for (int events = 0; events < kMaxWalkCrossings; ++events) {
    double fraction;
    const int corner = walker.ExitCorner(fraction);
    walker.Advance(fraction);
    if (corner < 0) return Finite(walker.at);
    const int edge = (corner + 1) % 3;
    walker.at[corner] = 0;
    const EdgeShape shape = ShapeOf(surface, walker.face, edge);
    const int32_t next = topology.face_neighbors[walker.face][edge];
    const int next_edge = topology.neighbor_edges[walker.face][edge];
    const EdgeShape next_shape = next < 0 ? EdgeShape{} : ShapeOf(surface, next, next_edge);
    if (next >= 0 && next_shape.solid()) {
      walker.Cross(edge, shape, next, next_edge, next_shape);
      slid_here = false;
      continue;
    }
    met_boundary = true;
    if (slid_here) return Finite(walker.at);
    walker.Slide(edge, shape);
    slid_here = true;
  }
  return false;
}

bool HasBoundaryEdge(const Surface& surface, int32_t face) {
  const auto& n = surface.topology().face_neighbors[face];
  return n[0] < 0 || n[1] < 0 || n[2] < 0;
}

std::vector<WalkResult> WalkEach(const Gaussians& gaussians,
                                 const Embedding& embedding,
                                 const Surface& surface) {
  std::vector<WalkResult> results(gaussians.size());
  const auto& offsets = gaussians.values[kPosition];
  ParallelFor(results.size(), [&](size_t i) {
    const SurfacePoint start{embedding.triangle[i], embedding.barycentric[i]};
    if (offsets[3 * i] == 0 && offsets[3 * i + 1] == 0)
      results[i] = {start, WalkStatus::kWithin};
    else
      results[i] = Walk(surface, start, offsets[3 * i], offsets[3 * i + 1]);
  });
  return results;
}

}  // namespace

WalkResult Walk(const Surface& surface, const SurfacePoint& start, float du, float dv) {
  const double u = start.barycentric[0], v = start.barycentric[1];
  Walker walker{start.triangle, {u, v, 1 - u - v}, {du, dv, -double(du) - double(dv)}};
  if (!Finite(walker.at) || !Finite(walker.step) || TooLong(walker.step))
    return {start, WalkStatus::kInvalid};
  walker.at = KeepInsideTriangle(walker.at);
  bool met_boundary = false;
  if (!Follow(surface, walker, met_boundary)) return {start, WalkStatus::kInvalid};
  const Weights at = KeepInsideTriangle(walker.at);
  const WalkStatus status = met_boundary                    ? WalkStatus::kBoundary
                            : walker.face != start.triangle ? WalkStatus::kCrossed
                                                            : WalkStatus::kWithin;
  return {{walker.face, {float(at[0]), float(at[1])}}, status};
}

WalkReport WalkAll(Gaussians& gaussians,
                   Embedding& embedding,
                   const Surface& surface,
                   int boundary_face_cap) {
  std::vector<int> count(surface.faces().size());
  for (size_t i = 0; i < gaussians.size(); ++i) {
    if (size_t(embedding.triangle[i]) >= count.size())
      throw Error("avatar",
                  "triangle[" + std::to_string(i) + "]",
                  std::to_string(embedding.triangle[i]) + " of " + std::to_string(count.size()));
    ++count[embedding.triangle[i]];
  }
  const std::vector<WalkResult> results = WalkEach(gaussians, embedding, surface);
  WalkReport report;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    auto& offsets = gaussians.values[kPosition];
    offsets[3 * i] = offsets[3 * i + 1] = 0;
    const auto& [point, status] = results[i];
    const bool crossed = point.triangle != embedding.triangle[i];
    const bool refused = crossed && count[point.triangle] >= boundary_face_cap &&
                         HasBoundaryEdge(surface, point.triangle);
    if (status == WalkStatus::kInvalid) report.invalid.push_back(uint32_t(i));
    if (status == WalkStatus::kBoundary || refused)
      report.stopped_at_boundary.push_back(uint32_t(i));
    if (status == WalkStatus::kInvalid || refused) continue;
    if (crossed) report.crossed.push_back(uint32_t(i));
    --count[embedding.triangle[i]];
    ++count[point.triangle];
    embedding.triangle[i] = point.triangle;
    embedding.barycentric[i] = point.barycentric;
  }
  return report;
}

}  // namespace cosplat

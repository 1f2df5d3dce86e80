// The walk of one Gaussian over the canonical mesh: the implementation of avatar/surface/walk.h,
// which documents it, for the CPU and for a device (one thread per Gaussian).
#pragma once

#include "avatar/surface/kernels/triangle.h"

namespace cosplat {

enum class WalkStatus {
  kWithin,    // ended in the triangle in which it began
  kCrossed,   // ended in another triangle
  kBoundary,  // met a boundary; may have crossed edges as well
  kInvalid    // not finite, or longer than kMaxWalkCrossings triangles: the point is not moved
};

// A step between two walks is a few triangles long; this many go a quarter of the way around
// FLAME's finely tessellated eyeballs.
constexpr int kMaxWalkCrossings = 256;

namespace math {

// Edge i of a face (corner i to corner i + 1) with the corner opposite to it.
struct EdgeShape {
  double length;
  double foot;    // projection of the opposite corner onto the edge, measured from corner i
  double height;  // of the opposite corner over the edge
  COSPLAT_HD bool IsSolid() const { return length > 0 && height > 0; }
};

COSPLAT_HD EdgeShape ShapeOfEdge(const MeshArrays& mesh, int32_t face, int edge) {
  const Vec3<double> a = CanonicalPosition(mesh, face, edge);
  const Vec3<double> ab = CanonicalPosition(mesh, face, (edge + 1) % 3) - a;
  const Vec3<double> ac = CanonicalPosition(mesh, face, (edge + 2) % 3) - a;
  const double length = Sqrt(Dot(ab, ab));
  if (length == 0) return {0, 0, 0};
  const Vec3<double> area = Cross(ab, ac);
  return {length, Dot(ac, ab) / length, Sqrt(Dot(area, area)) / length};
}

struct Walker {
  int32_t face;
  Weights barycentric;
  Weights offset;  // the rest of (du, dv), as changes of all three weights; sums to zero

  // In triangles of similar size, a weight falls by at most 1 per triangle.
  COSPLAT_HD bool IsTooLong() const {
    for (int i = 0; i < 3; ++i)
      if (Abs(offset[i]) > kMaxWalkCrossings) return true;
    return false;
  }

  // The corner opposite to the edge through which the step leaves the face, and the fraction of the
  // step at which it does; -1 if the step ends inside.
  COSPLAT_HD int ExitCorner(double& fraction) const {
    int corner = -1;
    fraction = 1;
    for (int i = 0; i < 3; ++i) {
      if (!(offset[i] < 0) || !(barycentric[i] < -offset[i] * fraction)) continue;
      fraction = barycentric[i] / -offset[i];
      corner = i;
    }
    return corner;
  }

  COSPLAT_HD void Advance(double fraction) {
    for (int i = 0; i < 3; ++i) {
      barycentric[i] += fraction * offset[i];
      offset[i] *= 1 - fraction;
    }
  }

  // Length of the step's component along `edge`.
  COSPLAT_HD double Along(int edge, const EdgeShape& shape) const {
    return offset[(edge + 1) % 3] * shape.length + offset[(edge + 2) % 3] * shape.foot;
  }

  // Keeps only the step's component along the boundary edge.
  COSPLAT_HD void Slide(int edge, const EdgeShape& shape) {
    const double share = shape.length > 0 ? Along(edge, shape) / shape.length : 0;
    offset[(edge + 1) % 3] = share;
    offset[edge] = -share;
    offset[(edge + 2) % 3] = 0;
    barycentric = KeepInsideTriangle(barycentric);
  }

  // Moves to the face across `edge`, unfolded into this face's plane: the step's components along
  // and across the edge keep their lengths. A path that meets a vertex passes around it, face by
  // face, until it has gone half way around, that is, straight on.
  COSPLAT_HD void Cross(
      int edge, const EdgeShape& shape, int32_t next, int next_edge, const EdgeShape& shape2) {
    const double along = Along(edge, shape);
    const double across = -offset[(edge + 2) % 3] * shape.height;
    const double a = barycentric[(edge + 1) % 3], b = barycentric[edge];
    const int end = (next_edge + 1) % 3, apex = (next_edge + 2) % 3;
    face = next;
    barycentric[next_edge] = a;
    barycentric[end] = b;
    barycentric[apex] = 0;
    offset[apex] = across / shape2.height;
    offset[end] = (-along - offset[apex] * shape2.foot) / shape2.length;
    offset[next_edge] = -offset[apex] - offset[end];
  }
};

// Returns whether the walk ended within kMaxWalkCrossings. Sets `met_boundary` if it met a
// boundary.
COSPLAT_HD bool FollowStep(const MeshArrays& mesh, Walker& walker, bool& met_boundary) {
  bool slid_here = false;  // already slid along a boundary edge of this face
  for (int events = 0; events < kMaxWalkCrossings; ++events) {
    double fraction;
    const int corner = walker.ExitCorner(fraction);
    walker.Advance(fraction);
    if (corner < 0) return AllFinite(walker.barycentric);
    const int edge = (corner + 1) % 3;
    walker.barycentric[corner] = 0;
    const EdgeShape shape = ShapeOfEdge(mesh, walker.face, edge);
    const int32_t next = NeighborOf(mesh, walker.face, edge);
    const int next_edge = mesh.neighbor_edges[3 * size_t(walker.face) + edge];
    const EdgeShape next_shape = next < 0 ? EdgeShape{0, 0, 0} : ShapeOfEdge(mesh, next, next_edge);
    if (next >= 0 && next_shape.IsSolid()) {
      walker.Cross(edge, shape, next, next_edge, next_shape);
      slid_here = false;
      continue;
    }
    met_boundary = true;
    if (slid_here) return AllFinite(walker.barycentric);
    walker.Slide(edge, shape);
    slid_here = true;
  }
  return false;
}

struct WalkEnd {
  int32_t face;
  float u, v;
  WalkStatus status;
};

// Walks from (u, v) on a face by (du, dv).
COSPLAT_HD WalkEnd
WalkFrom(const MeshArrays& mesh, int32_t face, float u, float v, float du, float dv) {
  const WalkEnd stays{face, u, v, WalkStatus::kInvalid};
  Walker walker{face, {{u, v, 1 - double(u) - double(v)}}, {{du, dv, -double(du) - double(dv)}}};
  if (!AllFinite(walker.barycentric) || !AllFinite(walker.offset) || walker.IsTooLong())
    return stays;
  walker.barycentric = KeepInsideTriangle(walker.barycentric);
  bool met_boundary = false;
  if (!FollowStep(mesh, walker, met_boundary)) return stays;
  const Weights barycentric = KeepInsideTriangle(walker.barycentric);
  const WalkStatus status = met_boundary          ? WalkStatus::kBoundary
                            : walker.face != face ? WalkStatus::kCrossed
                                                  : WalkStatus::kWithin;
  return {walker.face, float(barycentric[0]), float(barycentric[1]), status};
}

// Walks a Gaussian. One whose du and dv are zero keeps its barycentrics exactly.
COSPLAT_HD WalkEnd WalkGaussian(const MeshArrays& mesh,
                                int32_t face,
                                const float* barycentric,
                                const float* offset) {
  if (offset[0] == 0 && offset[1] == 0)
    return {face, barycentric[0], barycentric[1], WalkStatus::kWithin};
  return WalkFrom(mesh, face, barycentric[0], barycentric[1], offset[0], offset[1]);
}

// Accepts or refuses the walks of a mesh's Gaussians, in order of their indices.
struct WalkTaker {
  MeshArrays mesh;
  int boundary_face_cap;
  int32_t* count;  // [F] current Gaussians of each face; exact at least for boundary faces

  // Whether the walk from one face to another is accepted: not if that is a full boundary face.
  COSPLAT_HD bool Accept(int32_t from, int32_t to) const {
    if (from != to && count[to] >= boundary_face_cap && HasBoundaryEdge(mesh, to)) return false;
    --count[from];
    ++count[to];
    return true;
  }
};

}  // namespace math

// The outcome of a Gaussian's walk, as bit flags.
enum WalkOutcome : uint8_t { kWalkCrossed = 1, kWalkStopped = 2, kWalkInvalid = 4 };

// The steps of TriangleWalk (avatar/surface/walk.h), with one Gaussian per index unless noted.

struct WalkOne {
  MeshArrays mesh;
  const int32_t* triangle;
  const float* barycentric;
  View<const float> position;
  View<math::WalkEnd> ends;
  View<uint8_t> taken;
  View<uint64_t> touches;  // [N + 1] flags of walks from or to a face with a boundary edge
  COSPLAT_HD void operator()(size_t i) const {
    touches[i] = 0;
    if (i == ends.count) return;
    const int32_t from = triangle[i];
    const math::WalkEnd end = math::WalkGaussian(mesh, from, barycentric + 2 * i, &position[3 * i]);
    ends[i] = end;
    taken[i] = end.status != WalkStatus::kInvalid;
    touches[i] = taken[i] && end.face != from &&
                 (math::HasBoundaryEdge(mesh, from) || math::HasBoundaryEdge(mesh, end.face));
  }
};

struct ListTouching {
  View<const uint64_t> places;
  View<uint32_t> list;
  COSPLAT_HD void operator()(size_t i) const {
    if (places[i + 1] != places[i]) list[places[i]] = uint32_t(i);
  }
};

// One face per index.
struct CountOnFace {
  const uint32_t* begin;  // [F + 1]
  View<int32_t> count;
  COSPLAT_HD void operator()(size_t f) const { count[f] = int32_t(begin[f + 1] - begin[f]); }
};

// Run sequentially by a single thread: whether a walk onto a face with a boundary edge is accepted
// depends on the walks before it. Only a few percent of the Gaussians touch such a face.
struct TakeEach {
  math::WalkTaker taker;
  const int32_t* triangle;
  View<const uint32_t> list;
  const uint64_t* how_many;
  View<const math::WalkEnd> ends;
  View<uint8_t> taken;
  COSPLAT_HD void operator()(size_t) const {
    for (size_t k = 0; k < *how_many; ++k) {
      const uint32_t i = list[k];
      taken[i] = taker.Accept(triangle[i], ends[i].face);
    }
  }
};

struct SettleWalk {
  View<const math::WalkEnd> ends;
  View<const uint8_t> taken;
  int32_t* triangle;
  float* barycentric;
  View<float> position;
  View<uint8_t> outcomes;
  COSPLAT_HD void operator()(size_t i) const {
    const math::WalkEnd& end = ends[i];
    position[3 * i] = position[3 * i + 1] = 0;
    const bool invalid = end.status == WalkStatus::kInvalid;
    const bool stopped = end.status == WalkStatus::kBoundary || (!invalid && !taken[i]);
    const bool crossed = taken[i] && end.face != triangle[i];
    outcomes[i] = uint8_t((crossed ? kWalkCrossed : 0) | (stopped ? kWalkStopped : 0) |
                          (invalid ? kWalkInvalid : 0));
    if (!taken[i]) return;
    triangle[i] = end.face;
    barycentric[2 * i] = end.u;
    barycentric[2 * i + 1] = end.v;
  }
};

struct ForgetMoment {
  View<const uint8_t> outcomes;
  View<float> moment;
  COSPLAT_HD void operator()(size_t i) const {
    if (outcomes[i]) moment[3 * i] = moment[3 * i + 1] = 0;
  }
};

}  // namespace cosplat

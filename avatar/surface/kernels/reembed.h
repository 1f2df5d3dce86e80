// Re-embedding of a point near the canonical mesh: the implementation of Reembed, documented in
// avatar/surface/sample.h, for the CPU and for a device (one thread per point).
#pragma once

#include "avatar/surface/kernels/face_search.h"
#include "avatar/surface/kernels/triangle.h"

namespace cosplat::math {

// The search ends after this many faces without an improvement.
constexpr int kMaxFruitlessFaces = 48;
// Newton's method for P(b) + d n(b) = x converges quadratically; where it converges, a few steps
// suffice.
constexpr int kNewtonSteps = 12;
// Moves to a neighbouring face during Newton's method.
constexpr int kMaxFaceChanges = 8;

struct CanonicalTriangle {
  Vec3<double> position[3], normal[3];

  COSPLAT_HD Vec3<double> PointAt(const Weights& b) const {
    return position[0] * b[0] + position[1] * b[1] + position[2] * b[2];
  }
  COSPLAT_HD Vec3<double> NormalSum(const Weights& b) const {
    return normal[0] * b[0] + normal[1] * b[1] + normal[2] * b[2];
  }
};
COSPLAT_HD CanonicalTriangle TriangleOf(const MeshArrays& mesh, int32_t face) {
  CanonicalTriangle t;
  for (int c = 0; c < 3; ++c) {
    t.position[c] = CanonicalPosition(mesh, face, c);
    t.normal[c] = CanonicalNormal(mesh, face, c);
  }
  return t;
}

// Weights of the closest point to x on the segment from corner i to corner j.
COSPLAT_HD Weights ClosestOnEdge(const CanonicalTriangle& t, int i, int j, const Vec3<double>& x) {
  const Vec3<double> edge = t.position[j] - t.position[i];
  const double length2 = Dot(edge, edge);
  const double s = length2 > 0 ? Clamp(Dot(x - t.position[i], edge) / length2, 0.0, 1.0) : 0.0;
  Weights b{};
  b[i] = 1 - s;
  b[j] = s;
  return b;
}

// Weights of the closest point to x: its projection onto the plane if that lies inside, otherwise
// the closest point of the three edges.
COSPLAT_HD Weights ClosestOnTriangle(const CanonicalTriangle& t, const Vec3<double>& x) {
  const Vec3<double> a = t.position[1] - t.position[0], c = t.position[2] - t.position[0];
  const Vec3<double> normal = Cross(a, c), to_x = x - t.position[0];
  const double n2 = Dot(normal, normal);
  if (n2 > 0) {
    const double b1 = Dot(Cross(to_x, c), normal) / n2;
    const double b2 = Dot(Cross(a, to_x), normal) / n2;
    if (b1 >= 0 && b2 >= 0 && b1 + b2 <= 1) return {{1 - b1 - b2, b1, b2}};
  }
  Weights best{};
  double best_distance2 = INFINITY;
  for (int i = 0; i < 3; ++i) {
    const Weights b = ClosestOnEdge(t, i, (i + 1) % 3, x);
    const Vec3<double> off = t.PointAt(b) - x;
    if (Dot(off, off) < best_distance2) {
      best_distance2 = Dot(off, off);
      best = b;
    }
  }
  return best;
}

struct ClosestPlace {
  int32_t face;
  Weights barycentric;
  double distance2;
};

COSPLAT_HD ClosestPlace ClosestOnFace(const MeshArrays& mesh, int32_t face, const Vec3<double>& x) {
  const CanonicalTriangle t = TriangleOf(mesh, face);
  const Weights b = ClosestOnTriangle(t, x);
  const Vec3<double> off = t.PointAt(b) - x;
  return {face, b, Dot(off, off)};
}

// Closest point on the faces around `start`, searched nearest first.
COSPLAT_HD ClosestPlace ClosestAround(const MeshArrays& mesh,
                                      int32_t start,
                                      const Vec3<double>& x,
                                      FaceSearch& search) {
  search.Start();
  search.See(start);
  FaceAtDistance best{ClosestOnFace(mesh, start, x).distance2, start};
  search.Push(best);
  int fruitless = 0;
  while (!search.IsEmpty() && !search.IsFull() && fruitless < kMaxFruitlessFaces) {
    const FaceAtDistance next = search.PopNearest();
    ++fruitless;
    if (next.distance2 < best.distance2) {
      best = next;
      fruitless = 0;
    }
    for (int c = 0; c < 3; ++c) {
      const size_t v = size_t(mesh.faces[3 * size_t(next.face) + c]);
      for (int32_t k = mesh.vertex_face_begin[v]; k < mesh.vertex_face_begin[v + 1]; ++k) {
        const int32_t face = mesh.vertex_faces[k];
        if (search.See(face)) search.Push({ClosestOnFace(mesh, face, x).distance2, face});
      }
    }
  }
  return ClosestOnFace(mesh, best.face, x);
}

struct Reembedded {
  int32_t face;
  Weights barycentric;
  double d;
  double residual;
};

// The best embedding with weights `b` (inside the triangle): d is the projection onto their normal.
COSPLAT_HD Reembedded ProjectOnFace(const MeshArrays& mesh,
                                    int32_t face,
                                    const Weights& b,
                                    const Vec3<double>& x) {
  const CanonicalTriangle t = TriangleOf(mesh, face);
  const Vec3<double> p = t.PointAt(b), n = Normalize(t.NormalSum(b));
  const double d = Dot(x - p, n);
  const Vec3<double> off = p + n * d - x;
  return {face, b, d, Sqrt(Dot(off, off))};
}

// Solves P + h N = x for (b_0, b_1, h) on the plane of one triangle, where N is the weighted sum of
// the normals, not normalised (the line is the same). Returns false when the equations become
// singular.
COSPLAT_HD bool SolveOnTriangle(const CanonicalTriangle& t, const Vec3<double>& x, Weights& b) {
  double h = Dot(x - t.PointAt(b), Normalize(t.NormalSum(b)));
  const Vec3<double> p0 = t.position[0] - t.position[2], p1 = t.position[1] - t.position[2];
  const Vec3<double> m0 = t.normal[0] - t.normal[2], m1 = t.normal[1] - t.normal[2];
  for (int i = 0; i < kNewtonSteps; ++i) {
    const Vec3<double> n = t.NormalSum(b), error = x - t.PointAt(b) - n * h;
    const Vec3<double> c0 = p0 + m0 * h, c1 = p1 + m1 * h;
    const double det = Dot(Cross(c0, c1), n);
    if (!(Abs(det) > 1e-12 * Sqrt(Dot(c0, c0) * Dot(c1, c1)))) return false;
    const double s0 = Dot(Cross(error, c1), n) / det;
    const double s1 = Dot(Cross(c0, error), n) / det;
    b[0] += s0;
    b[1] += s1;
    b[2] -= s0 + s1;
    h += Dot(Cross(c0, c1), error) / det;
    if (Abs(s0) + Abs(s1) < 1e-12) break;
  }
  return std::isfinite(b[0] + b[1] + b[2] + h);
}

// Embeds x, which must be finite, near face `start`, which must exist. Solves on the closest face;
// if the solution lies outside it, continues on the face across the edge by which it left.
COSPLAT_HD Reembedded ReembedNear(const MeshArrays& mesh,
                                  int32_t start,
                                  const Vec3<double>& x,
                                  FaceSearch& search) {
  const ClosestPlace from = ClosestAround(mesh, start, x, search);
  Reembedded best = ProjectOnFace(mesh, from.face, KeepInsideTriangle(from.barycentric), x);
  int32_t face = from.face;
  Weights b = from.barycentric;
  for (int change = 0; change <= kMaxFaceChanges; ++change) {
    if (!SolveOnTriangle(TriangleOf(mesh, face), x, b)) break;
    const Reembedded here = ProjectOnFace(mesh, face, KeepInsideTriangle(b), x);
    if (here.residual < best.residual) best = here;
    int lowest = 0;
    for (int i = 1; i < 3; ++i)
      if (b[i] < b[lowest]) lowest = i;
    if (b[lowest] >= 0) break;
    face = NeighborOf(mesh, face, (lowest + 1) % 3);
    if (face < 0) break;
    b = ClosestOnFace(mesh, face, x).barycentric;
  }
  return best;
}

}  // namespace cosplat::math

// Points on the triangles of the canonical mesh, in double precision: shared by walk.h and
// reembed.h, on the CPU and on a device.
#pragma once

#include "avatar/math/embed.h"
#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/kernels/gather.h"

namespace cosplat::math {

// Barycentric weights of a triangle's corners, which sum to 1, or changes of them, which sum to 0.
using Weights = Three<double>;

COSPLAT_HD bool AllFinite(const Weights& w) {
  return std::isfinite(w[0]) && std::isfinite(w[1]) && std::isfinite(w[2]);
}

// The smallest weight of points that a search or a walk has moved; the rounding of 1 - u - v in
// float is 1.2e-7.
constexpr double kInsideTriangle = 1e-6;
// Raises smaller weights to it and renormalises the sum to 1.
COSPLAT_HD Weights KeepInsideTriangle(Weights w) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    if (w[i] < kInsideTriangle) w[i] = kInsideTriangle;
    sum += w[i];
  }
  for (int i = 0; i < 3; ++i) w[i] /= sum;
  return w;
}

COSPLAT_HD SurfaceVertex<float> CanonicalVertex(const MeshArrays& mesh, int32_t face, int corner) {
  const auto vertex = size_t(mesh.faces[3 * size_t(face) + corner]);
  return SurfaceVertexOf(mesh.vertices + kSurfaceVertexFloats * vertex);
}
COSPLAT_HD Vec3<double> CanonicalPosition(const MeshArrays& mesh, int32_t face, int corner) {
  const Vec3<float> p = CanonicalVertex(mesh, face, corner).position;
  return {p.x, p.y, p.z};
}
COSPLAT_HD Vec3<double> CanonicalNormal(const MeshArrays& mesh, int32_t face, int corner) {
  const Vec3<float> n = CanonicalVertex(mesh, face, corner).normal;
  return {n.x, n.y, n.z};
}

COSPLAT_HD int32_t NeighborOf(const MeshArrays& mesh, int32_t face, int edge) {
  return mesh.face_neighbors[3 * size_t(face) + edge];
}
COSPLAT_HD bool HasBoundaryEdge(const MeshArrays& mesh, int32_t face) {
  for (int edge = 0; edge < 3; ++edge)
    if (NeighborOf(mesh, face, edge) < 0) return true;
  return false;
}

}  // namespace cosplat::math

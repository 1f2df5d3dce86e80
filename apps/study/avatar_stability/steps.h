// Positions and steps on the faces of a mesh.
#pragma once

#include <array>
#include <vector>

#include "avatar/surface/surface.h"

namespace cosplat {

// vertices: [V, 3].
inline math::Vec3<float> VertexAt(const std::vector<float>& vertices, int32_t v) {
  return {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
}

// On the canonical mesh, as in the next two functions.
inline math::Vec3<float> CornerAt(const Surface& surface, int32_t face, int corner) {
  return surface.canonical()[surface.faces()[face][corner]].position;
}

inline math::Vec3<float> PlaceOf(const Surface& surface, const SurfacePoint& p) {
  const float u = p.barycentric[0], v = p.barycentric[1];
  return CornerAt(surface, p.triangle, 0) * u + CornerAt(surface, p.triangle, 1) * v +
         CornerAt(surface, p.triangle, 2) * (1 - u - v);
}

// (du, dv) of a step in space, projected onto the face's plane.
inline std::array<float, 2> StepOn(const Surface& surface,
                                   int32_t face,
                                   const math::Vec3<float>& step) {
  const math::Vec3<float> a = CornerAt(surface, face, 0) - CornerAt(surface, face, 2);
  const math::Vec3<float> b = CornerAt(surface, face, 1) - CornerAt(surface, face, 2);
  const float aa = Dot(a, a), ab = Dot(a, b), bb = Dot(b, b);
  const float as = Dot(a, step), bs = Dot(b, step), det = aa * bb - ab * ab;
  return {(bb * as - ab * bs) / det, (aa * bs - ab * as) / det};
}

}  // namespace cosplat

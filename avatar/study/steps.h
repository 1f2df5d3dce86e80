// Places and steps on the faces of a canonical mesh, for the walking cases.
#pragma once

#include <array>

#include "avatar/surface.h"

namespace cosplat {

inline math::Vec3<float> CornerAt(const Surface& surface, int32_t face, int corner) {
  return surface.canonical()[surface.faces()[face][corner]].position;
}

inline math::Vec3<float> PlaceOf(const Surface& surface, const SurfacePoint& p) {
  const float u = p.barycentric[0], v = p.barycentric[1];
  return CornerAt(surface, p.triangle, 0) * u + CornerAt(surface, p.triangle, 1) * v +
         CornerAt(surface, p.triangle, 2) * (1 - u - v);
}

// (du, dv) of a step in space, projected on the face's plane.
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

// Conversion between axis-angle rotations (FLAME's joints) and quaternions, and interpolation.
//
// Used by avatar/model/avatar_mesh.cpp and avatar/live/ to blend poses. Source: Shoemake 1985
// (slerp). Nothing here is trained, so there are no derivatives.
#pragma once

#include <array>
#include <cmath>

#include "splat/math/quat.h"

namespace cosplat::math {

using AxisAngle = std::array<float, 3>;  // radians

inline Quat<float> QuatOfAxisAngle(const AxisAngle& r) {
  const float angle = std::hypot(r[0], r[1], r[2]);
  const float s = angle > 1e-6f ? std::sin(angle / 2) / angle : 0.5f;
  return {std::cos(angle / 2), r[0] * s, r[1] * s, r[2] * s};
}

// q must be a unit quaternion. Angles are up to 2 pi.
inline AxisAngle AxisAngleOf(const Quat<float>& q) {
  const float sine = std::hypot(q.x, q.y, q.z);
  const float s = sine > 1e-6f ? 2 * std::atan2(sine, q.w) / sine : 2.0f;
  return {q.x * s, q.y * s, q.z * s};
}

// q or -q, which is the same rotation: the one that turns by at most pi.
inline Quat<float> ShorterWay(const Quat<float>& q) { return q.w < 0 ? q * -1.0f : q; }

// Interpolates from a (w = 0) to b (w = 1) the shorter way.
inline Quat<float> Between(const Quat<float>& a, const Quat<float>& b, float w) {
  AxisAngle turn = AxisAngleOf(ShorterWay(Multiply(b, Conjugate(a))));
  for (float& x : turn) x *= w;
  return Normalize(Multiply(QuatOfAxisAngle(turn), a));
}

}  // namespace cosplat::math

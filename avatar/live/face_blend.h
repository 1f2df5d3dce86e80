// Interpolation between faces, for FaceGuard and FaceSmoother.
#pragma once

#include <cstddef>

#include "avatar/math/turn.h"
#include "flame/model.h"

namespace cosplat {

// Interpolates expression, pose and translation from a (w = 0, exactly) to b (w = 1, exactly);
// joints rotate the shorter way. The expressions of both and of `out` must have equal sizes; shape
// and static offset are left unchanged. `out` may be a or b.
inline void BlendFaces(const FlameParams& a, const FlameParams& b, float w, FlameParams& out) {
  const auto between = [w](float x, float y) { return w >= 1 ? y : x + w * (y - x); };
  for (size_t i = 0; i < out.expression.size(); ++i)
    out.expression[i] = between(a.expression[i], b.expression[i]);
  for (size_t k = 0; k < 3; ++k) out.translation[k] = between(a.translation[k], b.translation[k]);
  for (size_t j = 0; j < kFlameJoints; ++j) {
    const math::AxisAngle from = a.pose[j], to = b.pose[j];
    if (w <= 0 || w >= 1 || from == to)
      out.pose[j] = w <= 0 ? from : to;
    else
      out.pose[j] = math::AxisAngleOf(math::ShorterWay(
          math::Between(math::QuatOfAxisAngle(from), math::QuatOfAxisAngle(to), w)));
  }
}

// Copies expression, pose and translation; missing coefficients count as zero, excess ones are
// ignored.
inline void CopyFace(const FlameParams& from, FlameParams& to) {
  for (size_t i = 0; i < to.expression.size(); ++i)
    to.expression[i] = i < from.expression.size() ? from.expression[i] : 0;
  to.pose = from.pose;
  to.translation = from.translation;
}

}  // namespace cosplat

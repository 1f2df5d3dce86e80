// Faces between faces: how the guard and the smoother move from one to another.
#pragma once

#include <cstddef>

#include "avatar/math/turn.h"
#include "flame/model.h"

namespace cosplat {

// Expression, pose and translation that are the share w of the way from a to b, joints by the
// shorter way round; exactly a's at 0 and b's at 1. The expressions of both and of `out` have equal
// sizes; shape and static offset are left alone. `out` may be either.
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

// Expression, pose and translation; missing coefficients count as zero, excess ones are left out.
inline void CopyFace(const FlameParams& from, FlameParams& to) {
  for (size_t i = 0; i < to.expression.size(); ++i)
    to.expression[i] = i < from.expression.size() ? from.expression[i] : 0;
  to.pose = from.pose;
  to.translation = from.translation;
}

}  // namespace cosplat

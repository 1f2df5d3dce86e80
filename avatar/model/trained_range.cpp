#include <algorithm>
#include <cmath>

#include "avatar/math/turn.h"
#include "avatar/model/avatar_model.h"

namespace cosplat {

TrainedRange RangeOf(const std::vector<FlameParams>& frames) {
  TrainedRange range;
  size_t count = 0;
  for (const FlameParams& frame : frames) count = std::max(count, frame.expression.size());
  range.expression_least.resize(count);
  range.expression_most.resize(count);
  for (size_t f = 0; f < frames.size(); ++f) {
    const std::vector<float>& expression = frames[f].expression;
    for (size_t i = 0; i < count; ++i) {
      const float x = i < expression.size() ? expression[i] : 0;
      float &min = range.expression_least[i], &max = range.expression_most[i];
      min = f == 0 ? x : std::min(min, x);
      max = f == 0 ? x : std::max(max, x);
    }
    for (size_t j = 0; j < kFlameJoints; ++j) {
      const auto r = math::AxisAngleOf(math::ShorterWay(math::QuatOfAxisAngle(frames[f].pose[j])));
      range.angle[j] = std::max(range.angle[j], std::hypot(r[0], r[1], r[2]));
    }
  }
  return range;
}

}  // namespace cosplat

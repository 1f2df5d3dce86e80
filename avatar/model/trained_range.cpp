#include <algorithm>
#include <cmath>

#include "avatar/math/turn.h"
#include "avatar/model/avatar_model.h"

// What training saw: of parameters, and of directions.
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

bool IsBeyondFilm(const FilmedFrom& filmed,
                  const FlameParams& face,
                  const math::Vec3<float>& center,
                  const math::Vec3<float>& eye) {
  constexpr float kTolerance = 0.21f;  // radians
  const auto turn = [&](size_t joint) { return math::QuatOfAxisAngle(face.pose[joint]); };
  const math::Mat3<float> world_from_head = math::RotationOf(math::Multiply(turn(0), turn(1)));
  const math::Vec3<float> d = math::Normalize(math::TransposeTimes(world_from_head, eye - center));
  const auto is_beyond = [](float angle, const std::array<float, 2>& range) {
    return angle < range[0] - kTolerance || angle > range[1] + kTolerance;
  };
  return is_beyond(std::atan2(d.x, d.z), filmed.yaw) ||
         is_beyond(std::asin(std::clamp(d.y, -1.0f, 1.0f)), filmed.pitch);
}

}  // namespace cosplat

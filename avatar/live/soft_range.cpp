#include "avatar/live/soft_range.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"
#include "avatar/math/turn.h"

namespace cosplat {

SoftRange::SoftRange(size_t expression_count, const std::optional<TrainedRange>& trained)
    : least_(expression_count, trained ? 0.0f : -kUsualExpression),
      most_(expression_count, trained ? 0.0f : kUsualExpression) {
  if (!trained) return;
  const size_t count = std::min(expression_count, trained->expression_least.size());
  std::copy_n(trained->expression_least.begin(), count, least_.begin());
  std::copy_n(trained->expression_most.begin(), count, most_.begin());
  for (size_t j = 0; j < kFlameJoints; ++j) angle_[j] = std::max(angle_[j], trained->angle[j]);
}

bool SoftRange::Bring(FlameParams& face) const {
  bool changed = false;
  for (size_t i = 0; i < least_.size(); ++i) {
    float& x = face.expression[i];
    if (x >= least_[i] && x <= most_[i]) continue;
    const float margin = std::max(kMinMargin, 0.25f * (most_[i] - least_[i]));
    x = math::SoftClamp(x, least_[i], most_[i], margin);
    changed = true;
  }
  for (size_t j = 1; j < kFlameJoints; ++j) {
    std::array<float, 3>& r = face.pose[j];
    if (std::hypot(r[0], r[1], r[2]) <= angle_[j]) continue;
    r = math::AxisAngleOf(math::ShorterWay(math::QuatOfAxisAngle(r)));  // r may exceed a full turn
    const float angle = std::hypot(r[0], r[1], r[2]);
    if (angle <= angle_[j]) continue;
    const float softened = math::SoftClamp(angle, 0, angle_[j], kAngleMargin);
    for (float& x : r) x *= softened / angle;
    changed = true;
  }
  return changed;
}

}  // namespace cosplat

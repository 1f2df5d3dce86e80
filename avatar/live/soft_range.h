// Limits a live face to the range seen in training.
//
// live frame -> SoftRange -> avatar/live/guard.h. Inside the range nothing changes; outside it the
// excess is compressed (SoftClamp of avatar/math/one_euro.h), so that no motion stops abruptly.
#pragma once

#include <array>
#include <vector>

#include "avatar/model/avatar_model.h"

namespace cosplat {

class SoftRange {
 public:
  // Uses the range of `trained` or, if there is none, coefficients up to kUsualExpression in
  // magnitude and joint angles up to kUsualAngle. Joints may always turn as far as kUsualAngle.
  SoftRange(size_t expression_count, const std::optional<TrainedRange>& trained);

  // Returns whether anything was changed. `face` must have `expression_count` coefficients.
  bool Bring(FlameParams& face) const;

  // FLAME's coefficients are in standard deviations of the heads that it was built from.
  static constexpr float kUsualExpression = 3;
  // The most that a coefficient can exceed the range is a quarter of the range's width, but at
  // least this.
  static constexpr float kMinMargin = 0.5f;
  // Radians, by joint. A neck turns by 70 to 80 degrees, an eye by up to 50; FLAME's jaw is wide
  // open at 30. The root is the pose of the whole head in the world and is not limited.
  static constexpr std::array<float, kFlameJoints> kUsualAngle{0, 1.3f, 0.6f, 0.9f, 0.9f};
  static constexpr float kAngleMargin = 0.2f;  // radians

 private:
  std::vector<float> least_, most_;
  std::array<float, kFlameJoints> angle_ = kUsualAngle;
};

}  // namespace cosplat

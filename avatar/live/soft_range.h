// Faces that an avatar never made in training, brought back to those that it did.
//
// live frame -> SoftRange -> avatar/live/guard.h. Inside the range nothing changes; outside it the
// excess is squeezed (SoftClamp of avatar/math/one_euro.h), so that no motion stops short.
#pragma once

#include <array>
#include <vector>

#include "avatar/model/avatar_model.h"

namespace cosplat {

class SoftRange {
 public:
  // The range of `trained`, or where the avatar has none: coefficients within kUsualExpression of
  // zero and joints within the angles that a head's have. Joints may always turn as far as those.
  SoftRange(size_t expression_count, const std::optional<TrainedRange>& trained);

  // True when anything was changed. `face` has as many coefficients as this.
  bool Bring(FlameParams& face) const;

  // FLAME's coefficients are in standard deviations of the heads that it was made from.
  static constexpr float kUsualExpression = 3;
  // How far beyond the range a coefficient comes at most: a quarter of the range's width, at least
  // this.
  static constexpr float kMinMargin = 0.5f;
  // Radians, by joint. A neck turns by 70 to 80 degrees, an eye by up to 50; FLAME's jaw is wide
  // open at 30. The root is the whole head's place in the world and is free.
  static constexpr std::array<float, kFlameJoints> kUsualAngle{0, 1.3f, 0.6f, 0.9f, 0.9f};
  static constexpr float kAngleMargin = 0.2f;  // radians

 private:
  std::vector<float> least_, most_;
  std::array<float, kFlameJoints> angle_ = kUsualAngle;
};

}  // namespace cosplat

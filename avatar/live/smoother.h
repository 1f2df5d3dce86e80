// Removes jitter from live faces, at the cost of a delay (measured in docs/plugin.md).
//
// good frames -> FaceSmoother -> avatar/live/guard.h. Formula: avatar/math/one_euro.h.
#pragma once

#include <array>
#include <vector>

#include "avatar/math/one_euro.h"
#include "flame/model.h"

namespace cosplat {

class FaceSmoother {
 public:
  explicit FaceSmoother(size_t expression_count);

  // Filters every coefficient, every joint and the translation separately, in place. Speeds are
  // measured in typical motions of a face per second (1 for a coefficient, 0.1 rad, 0.02 m), so
  // that one beta suits all. dt: seconds since the previous frame; at 0 the output does not change.
  // `face` must have `expression_count` coefficients; the first one after Reset is returned
  // unchanged.
  void Smooth(const math::OneEuro& filter, float dt, FlameParams& face);
  void Reset() { started_ = false; }

 private:
  using Vector = std::array<float, 3>;

  void Start(const FlameParams& face);
  void StepExpression(const math::OneEuro& filter, float dt, const FlameParams& face);
  void StepJoint(const math::OneEuro& filter, float dt, const FlameParams& face, size_t joint);
  void StepTranslation(const math::OneEuro& filter, float dt, const FlameParams& face);

  bool started_ = false;
  FlameParams sample_;  // the last input
  FlameParams value_;   // the last output
  std::vector<float> expression_speed_;
  std::array<Vector, kFlameJoints> turn_speed_{};  // axis times angular speed
  Vector translation_speed_{};
};

}  // namespace cosplat

// Takes the trembling out of live faces, at the price of a delay (docs/plugin.md has it measured).
//
// good frames -> FaceSmoother -> avatar/live/guard.h. The formula is avatar/math/one_euro.h.
#pragma once

#include <array>
#include <vector>

#include "avatar/math/one_euro.h"
#include "flame/model.h"

namespace cosplat {

class FaceSmoother {
 public:
  explicit FaceSmoother(size_t expression_count);

  // Every coefficient, every joint and the translation by a filter of its own. Speeds are measured
  // in usual motions of a face per second, 1 for a coefficient, 0.1 rad, 0.02 m, so that one beta
  // serves all. dt: seconds since the frame before; at 0 nothing changes. `face` has as many
  // coefficients as this; the first one after Reset comes out as it went in.
  void Smooth(const math::OneEuro& filter, float dt, FlameParams& face);
  void Reset() { started_ = false; }

 private:
  using Vector = std::array<float, 3>;

  void Start(const FlameParams& face);
  void StepExpression(const math::OneEuro& filter, float dt, const FlameParams& face);
  void StepJoint(const math::OneEuro& filter, float dt, const FlameParams& face, size_t joint);
  void StepTranslation(const math::OneEuro& filter, float dt, const FlameParams& face);

  bool started_ = false;
  FlameParams sample_;  // the last that came in
  FlameParams value_;   // the last that went out
  std::vector<float> expression_speed_;
  std::array<Vector, kFlameJoints> turn_speed_{};  // axis times rate
  Vector translation_speed_{};
};

}  // namespace cosplat

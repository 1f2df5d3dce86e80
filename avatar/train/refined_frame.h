// The parameters of a frame while they are found together with the avatar
// (avatar/train/avatar_subject.h).
#pragma once

#include <utility>

#include "avatar/model/avatar_mesh.h"
#include "splat/math/adam.h"

namespace cosplat {

// Adam's learning rates, per step.
struct TrackRates {
  float expression;
  float pose;         // radians
  float translation;  // metres
};

struct RefinedFrame {
  AvatarPoser::Parameters params, m, v;  // m, v: Adam's moments
  int64_t step = 0;

  RefinedFrame() = default;
  RefinedFrame(AvatarPoser::Parameters first, size_t expressions) : params(std::move(first)) {
    for (AvatarPoser::Parameters* p : {&params, &m, &v}) p->expression.resize(expressions, 0.0f);
  }
  // One step of all but the bust.
  void Step(const AvatarPoser::Parameters& d, const TrackRates& rates) {
    ++step;
    Step(rates.expression, d.expression, params.expression, m.expression, v.expression);
    for (size_t j = 0; j < d.pose.size(); ++j)
      Step(rates.pose, d.pose[j], params.pose[j], m.pose[j], v.pose[j]);
    Step(rates.translation, d.translation, params.translation, m.translation, v.translation);
  }

 private:
  template <class Numbers>
  void Step(float rate, const Numbers& d, Numbers& values, Numbers& ms, Numbers& vs) const {
    const math::AdamStep at = math::AdamStepAt(rate, step);
    for (size_t k = 0; k < d.size(); ++k)
      math::AdamUpdate(at, math::UsableGradient(d[k]), values[k], ms[k], vs[k]);
  }
};

}  // namespace cosplat

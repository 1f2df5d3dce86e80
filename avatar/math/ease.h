// Curves without corners: from 0 to 1 in time, and back into a range in value.
//
// avatar/live/ moves faces by them. Nothing here is trained, so nothing has a derivative.
#pragma once

#include <algorithm>
#include <cmath>

namespace cosplat::math {

// 0 up to t = 0, 1 from t = 1 on; both level where they meet what is between (3 t^2 - 2 t^3).
inline float Ease(float t) {
  const float x = std::clamp(t, 0.0f, 1.0f);
  return x * x * (3 - 2 * x);
}

// x itself within [least, most]; outside it the excess e becomes margin * tanh(e / margin), which
// begins with slope 1 and never passes the margin. Continuous with its first two derivatives.
inline float SoftClamp(float x, float least, float most, float margin) {
  const float excess = x - std::clamp(x, least, most);
  return excess == 0 ? x : x - excess + margin * std::tanh(excess / margin);
}

}  // namespace cosplat::math

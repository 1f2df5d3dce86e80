// The one-euro filter: a low pass that is slow where a signal rests and fast where it moves, so
// that trembling goes and motion does not lag. Source: Casiez, Roussel & Vogel 2012; the speed is
// that of the samples, so that it does not depend on their rate.
//
// avatar/live/smoother.h filters faces by it. Nothing here is trained: no derivatives.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cosplat::math {

struct OneEuro {
  float min_cutoff = 2;    // Hz, at rest
  float beta = 1;          // Hz per unit of speed (units of the signal per second)
  float speed_cutoff = 1;  // Hz, of the speed's own low pass (their d_cutoff)
};

// Share of the new sample in a first-order low pass: dt / (dt + tau), tau = 1 / (2 pi cutoff).
// dt: seconds since the sample before.
inline float LowPassGain(float cutoff, float dt) {
  const float x = 2 * std::numbers::pi_v<float> * cutoff * dt;
  return x / (1 + x);
}

// Share of the new sample, given the filtered speed.
inline float OneEuroGain(const OneEuro& filter, float speed, float dt) {
  return LowPassGain(filter.min_cutoff + filter.beta * std::abs(speed), dt);
}

// Curves without corners: from 0 to 1 in time, and back into a range in value.
//
// avatar/live/ moves faces by them. Nothing here is trained, so nothing has a derivative.

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

// The one-euro filter: a low-pass filter with a low cutoff while a signal rests and a high one
// while it moves, so that jitter is removed and motion does not lag. Source: Casiez, Roussel &
// Vogel 2012; the speed is per second, so that it does not depend on the sampling rate. Also smooth
// curves for transitions and soft limits.
//
// Used by avatar/live/. Nothing here is trained, so there are no derivatives.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cosplat::math {

struct OneEuro {
  float min_cutoff = 2;    // Hz, at rest
  float beta = 1;          // Hz per unit of speed (units of the signal per second)
  float speed_cutoff = 1;  // Hz, of the low pass on the speed (d_cutoff in the paper)
};

// Weight of the new sample in a first-order low pass: dt / (dt + tau), tau = 1 / (2 pi cutoff).
// dt: seconds since the previous sample.
inline float LowPassGain(float cutoff, float dt) {
  const float x = 2 * std::numbers::pi_v<float> * cutoff * dt;
  return x / (1 + x);
}

// Weight of the new sample, given the filtered speed.
inline float OneEuroGain(const OneEuro& filter, float speed, float dt) {
  return LowPassGain(filter.min_cutoff + filter.beta * std::abs(speed), dt);
}

// Smoothstep: 3 t^2 - 2 t^3, clamped to 0 below t = 0 and to 1 above t = 1; flat at both ends.
inline float Ease(float t) {
  const float x = std::clamp(t, 0.0f, 1.0f);
  return x * x * (3 - 2 * x);
}

// x itself within [least, most]. Outside it the excess e becomes margin * tanh(e / margin), which
// starts with slope 1 and never exceeds the margin. Twice continuously differentiable.
inline float SoftClamp(float x, float min, float max, float margin) {
  const float excess = x - std::clamp(x, min, max);
  return excess == 0 ? x : x - excess + margin * std::tanh(excess / margin);
}

}  // namespace cosplat::math

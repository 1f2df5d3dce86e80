// The one-euro filter: a low pass that is slow where a signal rests and fast where it moves, so
// that trembling goes and motion does not lag. Source: Casiez, Roussel & Vogel 2012; the speed is
// that of the samples, so that it does not depend on their rate.
//
// avatar/live/smoother.h filters faces by it. Nothing here is trained: no derivatives.
#pragma once

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

}  // namespace cosplat::math

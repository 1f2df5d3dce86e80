// What a face does that no voice says: it blinks, and its head is never quite still.
#pragma once

#include <cstdint>

#include "avatar/live/phone_frame.h"
#include "splat/base/rng.h"

namespace cosplat {

class IdleMotion {
 public:
  explicit IdleMotion(uint64_t seed);

  struct Pose {
    HeadAngles head{};  // radians
    float lids = 0;     // 1: shut
  };
  // seconds: since the frame before. stress: how much louder than usual the voice is, from -1 to 1;
  // the head nods with it.
  Pose Next(float seconds, float stress);

 private:
  void PlanBlink();

  Rng rng_;
  double time_ = 0, blink_ = 0;  // seconds
  double drift_[3][3]{};         // of each angle: phases of slow waves
  float nod_ = 0;
};

}  // namespace cosplat

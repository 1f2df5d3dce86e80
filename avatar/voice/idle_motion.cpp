#include "avatar/voice/idle_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

constexpr float kShutting = 0.08f, kOpening = 0.16f;  // seconds of a blink
// Seconds between blinks of people who talk: some 20 a minute, far from regular.
constexpr float kShortestPause = 0.8f, kMeanPause = 2.2f;
// Slow waves of no common period: Hz, and radians of each angle.
constexpr double kWaves[] = {0.11, 0.23, 0.41};
constexpr double kSway[] = {0.012, 0.022, 0.010};
constexpr float kNod = 0.03f, kNodCutoff = 2;  // radians, Hz

}  // namespace

IdleMotion::IdleMotion(uint64_t seed) : rng_{seed} {
  for (auto& angle : drift_)
    for (double& phase : angle) phase = 2 * std::numbers::pi * double(rng_.Uniform());
  PlanBlink();
}

void IdleMotion::PlanBlink() {
  blink_ = time_ + double(kShortestPause - kMeanPause * std::log(1 - rng_.Uniform()));
}

IdleMotion::Pose IdleMotion::Next(float seconds, float stress) {
  time_ += double(seconds);
  Pose pose;
  nod_ += math::LowPassGain(kNodCutoff, seconds) * (std::clamp(stress, -1.0f, 1.0f) - nod_);
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t wave = 0; wave < 3; ++wave)
      pose.head[axis] += float(
          kSway[axis] * std::sin(2 * std::numbers::pi * kWaves[wave] * time_ + drift_[axis][wave]));
  pose.head[0] += kNod * nod_;
  const float since = float(time_ - blink_);
  if (since > kShutting + kOpening)
    PlanBlink();
  else if (since > 0)
    pose.lids = since < kShutting ? math::Ease(since / kShutting)
                                  : 1 - math::Ease((since - kShutting) / kOpening);
  return pose;
}

}  // namespace cosplat

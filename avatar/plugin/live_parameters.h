// What an avatar's face does right now: parameters as they come in, checked before anything of them
// is kept, so that what is bad leaves the last good ones in place.
//
// cosplat_set_... -> LiveParameters -> current() -> Player::Place.
#pragma once

#include <cstdint>
#include <limits>

#include "avatar/plugin/cosplat.h"
#include "flame/model.h"

namespace cosplat::plugin {

class LiveParameters {
 public:
  // Begins at `rest`. Keeps `expression_count` coefficients.
  LiveParameters(size_t expression_count, const FlameParams& rest);

  // Each throws CodedError and keeps what was set before when a number is not finite or too large,
  // something does not exist, or `time_ns` is earlier than the last.
  void Set(const cosplat_parameters& given);
  void SetExpression(uint32_t expression, float value, int64_t time_ns);
  void SetJoint(uint32_t joint, const float* axis_angle, int64_t time_ns);
  void SetTranslation(const float* translation, int64_t time_ns);
  void Reset();

  const FlameParams& current() const { return current_; }
  // `expression` points to our own.
  cosplat_parameters Get() const;

 private:
  void CheckTime(int64_t time_ns) const;

  static constexpr int64_t kNoTime = std::numeric_limits<int64_t>::min();

  FlameParams rest_, current_;
  int64_t time_ns_ = kNoTime;  // of what was set last
};

}  // namespace cosplat::plugin

// What an avatar's face does right now: parameters as they come in, checked before anything of them
// is kept, so that what is bad leaves the last good ones in place.
//
// cosplat_set_... -> LiveParameters -> current() -> Player::Place, or by way of LiveFace.
#pragma once

#include <cstdint>
#include <limits>

#include "avatar/live/guard.h"
#include "avatar/plugin/coded_error.h"
#include "flame/model.h"

namespace cosplat::plugin {

// Parameters that are not kept, and why, for who counts them.
class BadFrame : public CodedError {
 public:
  BadFrame(Verdict verdict,
           cosplat_status status,
           const std::string& field,
           const std::string& problem)
      : CodedError(status, field, problem), verdict_(verdict) {}
  Verdict verdict() const { return verdict_; }

 private:
  Verdict verdict_;
};

class LiveParameters {
 public:
  // Begins at `rest`. Keeps `expression_count` coefficients.
  LiveParameters(size_t expression_count, const FlameParams& rest);

  // Each throws BadFrame (CodedError where something does not exist) and keeps what was set before
  // when a number is not finite or too large or `time_ns` is earlier than the last.
  void Set(const cosplat_parameters& given);
  void SetExpression(uint32_t expression, float value, int64_t time_ns);
  void SetJoint(uint32_t joint, const float* axis_angle, int64_t time_ns);
  void SetTranslation(const float* translation, int64_t time_ns);
  void Reset();
  // Parameters that were found good elsewhere.
  void Keep(const FlameParams& params, int64_t time_ns);
  // Any time is new again.
  void ForgetTime() { time_ns_ = kNoTime; }

  const FlameParams& rest() const { return rest_; }
  const FlameParams& current() const { return current_; }
  int64_t time_ns() const { return time_ns_; }
  // `expression` points to our own.
  cosplat_parameters Get() const;

 private:
  void CheckTime(int64_t time_ns) const;

  static constexpr int64_t kNoTime = std::numeric_limits<int64_t>::min();

  FlameParams rest_, current_;
  int64_t time_ns_ = kNoTime;  // of what was set last
};

}  // namespace cosplat::plugin

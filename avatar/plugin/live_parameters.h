// The current parameters of an avatar's face. New ones are checked completely before any is stored,
// so that bad ones leave the last good ones in place.
//
// cosplat_set_... -> LiveParameters -> current() -> Player::Pose, directly or through
// InstanceFace.
#pragma once

#include <cstdint>
#include <limits>

#include "avatar/live/guard.h"
#include "avatar/plugin/coded_error.h"
#include "flame/model.h"

namespace cosplat::plugin {

// Thrown for refused parameters; the verdict is for the counts of FaceGuard.
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
  // Starts at `rest`, with `expression_count` coefficients, all zero.
  LiveParameters(size_t expression_count, const FlameParams& rest);

  // Throw BadFrame when a number is not finite or too large or `time_ns` is earlier than the last
  // one, and CodedError when an expression or joint does not exist; the parameters set before then
  // stay.
  void Set(const cosplat_parameters& given);
  void SetExpression(uint32_t expression, float value, int64_t time_ns);
  void SetJoint(uint32_t joint, const float* axis_angle, int64_t time_ns);
  void SetTranslation(const float* translation, int64_t time_ns);
  void Reset();
  // Stores parameters without checking them.
  void Keep(const FlameParams& params, int64_t time_ns);
  // Any time is accepted again.
  void ForgetTime() { time_ns_ = kNoTime; }

  const FlameParams& rest() const { return rest_; }
  const FlameParams& current() const { return current_; }
  int64_t time_ns() const { return time_ns_; }
  // `expression` points into this object.
  cosplat_parameters Get() const;

 private:
  void CheckTime(int64_t time_ns) const;

  static constexpr int64_t kNoTime = std::numeric_limits<int64_t>::min();

  FlameParams rest_, current_;
  int64_t time_ns_ = kNoTime;  // of the current parameters
};

}  // namespace cosplat::plugin

// The time-dependent part of an open avatar: takes frames from a drive and applies the policy for
// bad ones.
//
// cosplat_set_... and LiveSource -> InstanceFace -> FaceGuard -> Instance::Render. Has no effect
// before the first Advance: until then the parameters that were set are rendered.
#pragma once

#include <memory>
#include <string>

#include "avatar/live/guard.h"
#include "avatar/live/source.h"
#include "avatar/plugin/cosplat.h"
#include "avatar/plugin/live_parameters.h"

namespace cosplat::plugin {

class InstanceFace {
 public:
  // rest: must have as many coefficients as the model. Model and avatar must outlive this.
  InstanceFace(const FlameParams& rest, const FlameModel& flame, const AvatarModel& avatar);

  // Throws CodedError on a number out of range.
  void SetPolicy(const cosplat_policy& policy);
  // NULL removes the drive. If the drive cannot be opened, throws CodedError and keeps the previous
  // one.
  void SetDrive(const char* drive);
  // Good parameters set by the host, and the verdict on refused ones.
  void Offer(const LiveParameters& parameters);
  void CountRefused(Verdict verdict) { guard_.CountRefused(verdict); }
  // Stores the drive's newest frame in `parameters` if it is good. Throws CodedError when `now_ns`
  // is earlier than in the previous call.
  void Advance(int64_t now_ns, LiveParameters& parameters);
  void Reset();

  // The face to render; null before the first Advance.
  const FlameParams* shown() const { return shown_; }
  // Its texts are valid until the next call.
  cosplat_health Health();

 private:
  FaceGuard guard_;
  LiveSourceOptions source_options_;
  std::unique_ptr<LiveSource> source_;
  LiveFrame frame_;
  const FlameParams* shown_ = nullptr;
  int64_t now_ns_ = 0;  // of the last Advance
  std::string description_, problem_, notes_;
};

}  // namespace cosplat::plugin

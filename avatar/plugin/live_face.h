// What a host's avatar does on its own in time: takes frames from a drive, and follows the rule for
// bad ones.
//
// cosplat_set_... and LiveSource -> LiveFace -> FaceGuard -> Instance::Render. Before the first
// Advance it has no say: the parameters that are set are drawn.
#pragma once

#include <memory>
#include <string>

#include "avatar/live/guard.h"
#include "avatar/live/source.h"
#include "avatar/plugin/cosplat.h"
#include "avatar/plugin/live_parameters.h"

namespace cosplat::plugin {

class LiveFace {
 public:
  // rest: with as many coefficients as the model has.
  LiveFace(const FlameParams& rest, const std::optional<TrainedRange>& trained);

  // Throws CodedError on a number out of its range.
  void SetPolicy(const cosplat_policy& policy);
  // NULL: none. Throws CodedError, and keeps the drive before, when it cannot be opened.
  void SetDrive(const char* drive);
  // Parameters of the host's that were good, and those that were not.
  void Offer(const LiveParameters& parameters);
  void CountRefused(Verdict verdict) { guard_.CountRefused(verdict); }
  // The drive's good frames go into `parameters`. Throws CodedError when `now_ns` is earlier than
  // before.
  void Advance(int64_t now_ns, LiveParameters& parameters);
  void Reset();

  // What to draw; null before the first Advance.
  const FlameParams* shown() const { return shown_; }
  // Its texts stay until the next call.
  cosplat_health Health();

 private:
  FaceGuard guard_;
  LiveSourceOptions source_options_;
  std::unique_ptr<LiveSource> source_;
  LiveFrame frame_;
  const FlameParams* shown_ = nullptr;
  int64_t now_ns_ = 0;  // of the last Advance
  std::string description_, problem_;
};

}  // namespace cosplat::plugin

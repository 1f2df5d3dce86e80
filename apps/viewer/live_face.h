// The face from a live source as the viewer shows it, with bad frames handled by FaceGuard.
//
// LiveSource (avatar/live/source.h) -> FaceGuard (avatar/live/guard.h) -> LiveFace -> Session ->
// Shot.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "avatar/live/guard.h"
#include "avatar/live/source.h"

namespace cosplat::viewer {

class LiveFace {
 public:
  // rest: the face while there are no frames; its expression has as many coefficients as the model.
  LiveFace(std::unique_ptr<LiveSource> source,
           FlameParams rest,
           const std::optional<TrainedRange>& trained);

  // Takes the input received until `now_ns`.
  void Advance(int64_t now_ns);
  // The head's turn and place in the newest frame are those at rest from now on.
  void Calibrate();
  const FlameParams& Face() const { return face_; }
  // Time of the current face: that of the last good frame while frames arrive, otherwise that of
  // the last Advance.
  int64_t input_ns() const;
  // Good frames per second of late, by their own times; 0 before there are two.
  double frames_per_second() const { return interval_ns_ > 0 ? 1e9 / interval_ns_ : 0; }

  bool Ended() const { return source_->Ended(); }
  LiveCounts Counts() const { return source_->Counts(); }
  const FaceGuard& guard() const { return guard_; }
  std::string Description() const { return source_->Description(); }

 private:
  // A frame's head beside that of the calibration.
  void PutOnRest(FlameParams& face) const;

  std::unique_ptr<LiveSource> source_;
  FlameParams rest_;
  std::optional<FlameParams> calibration_;
  FaceGuard guard_;
  LiveFrame frame_;
  FlameParams raw_;  // the newest good frame, as it came
  FlameParams face_;
  int64_t now_ns_ = 0, frame_ns_ = 0;
  double interval_ns_ = 0;  // between good frames, a running mean
};

}  // namespace cosplat::viewer

#include "apps/viewer/live_face.h"

#include <utility>

namespace cosplat::viewer {

LiveFace::LiveFace(std::unique_ptr<LiveSource> source,
                   FlameParams rest,
                   const std::optional<TrainedRange>& trained)
    : source_(std::move(source)), guard_(rest, trained), face_(std::move(rest)) {}

void LiveFace::Advance(int64_t now_ns) {
  now_ns_ = now_ns;
  if (source_->Poll(now_ns, frame_) &&
      guard_.Offer(frame_.params, frame_.time_ns) == Verdict::kAccepted)
    frame_ns_ = frame_.time_ns;
  face_ = guard_.At(now_ns);
}

int64_t LiveFace::input_ns() const {
  const FaceState state = guard_.state();
  return state == FaceState::kLive || state == FaceState::kReturning ? frame_ns_ : now_ns_;
}

}  // namespace cosplat::viewer

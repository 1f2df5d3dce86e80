#include "apps/viewer/live_face.h"

#include <utility>

#include "avatar/math/turn.h"

namespace cosplat::viewer {
namespace {

constexpr size_t kRoot = 0, kNeck = 1;  // joints
constexpr double kNew = 0.1;            // weight of the newest interval

}  // namespace

LiveFace::LiveFace(std::unique_ptr<LiveSource> source,
                   FlameParams rest,
                   const std::optional<TrainedRange>& trained)
    : source_(std::move(source)), rest_(rest), guard_(rest, trained), face_(std::move(rest)) {}

void LiveFace::Advance(int64_t now_ns) {
  now_ns_ = now_ns;
  if (source_->Poll(now_ns, frame_)) {
    FlameParams raw = frame_.params;
    if (calibration_) PutOnRest(frame_.params);
    if (guard_.Offer(frame_.params, frame_.time_ns) == Verdict::kAccepted) {
      const double interval = double(frame_.time_ns - frame_ns_);
      if (frame_ns_ > 0) interval_ns_ += (interval_ns_ > 0 ? kNew : 1) * (interval - interval_ns_);
      frame_ns_ = frame_.time_ns;
      raw_ = std::move(raw);
    }
  }
  face_ = guard_.At(now_ns);
}

void LiveFace::Calibrate() {
  if (frame_ns_ > 0) calibration_ = raw_;
}

void LiveFace::PutOnRest(FlameParams& face) const {
  for (const size_t joint : {kRoot, kNeck})
    face.pose[joint] = math::AxisAngleOf(math::ShorterWay(math::Multiply(
        math::Multiply(math::QuatOfAxisAngle(face.pose[joint]),
                       math::Conjugate(math::QuatOfAxisAngle(calibration_->pose[joint]))),
        math::QuatOfAxisAngle(rest_.pose[joint]))));
  for (size_t k = 0; k < 3; ++k)
    face.translation[k] += rest_.translation[k] - calibration_->translation[k];
}

int64_t LiveFace::input_ns() const {
  const FaceState state = guard_.state();
  return state == FaceState::kLive || state == FaceState::kReturning ? frame_ns_ : now_ns_;
}

}  // namespace cosplat::viewer

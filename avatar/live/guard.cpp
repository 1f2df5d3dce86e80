#include "avatar/live/guard.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "avatar/live/face_blend.h"
#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

// begin_ns <= now_ns. Unsigned, because the difference of any two times must not overflow.
double SecondsSince(int64_t begin_ns, int64_t now_ns) {
  return 1e-9 * double(uint64_t(now_ns) - uint64_t(begin_ns));
}

Verdict Judge(const FlameParams& frame) {
  if (frame.expression.size() > kMaxExpressions) return Verdict::kWrongSize;
  bool finite = true, small = true;
  const auto look = [&](const auto& numbers) {
    for (const float x : numbers) {
      finite = finite && std::isfinite(x);
      small = small && std::abs(x) <= kMaxParameter;
    }
  };
  look(frame.expression);
  for (const auto& joint : frame.pose) look(joint);
  look(frame.translation);
  if (!finite) return Verdict::kNotFinite;
  return small ? Verdict::kAccepted : Verdict::kOutOfRange;
}

}  // namespace

FaceGuard::FaceGuard(FlameParams rest,
                     const std::optional<TrainedRange>& trained,
                     const GuardPolicy& policy)
    : policy_(policy),
      range_(rest.expression.size(), trained),
      smoother_(rest.expression.size()),
      rest_(std::move(rest)),
      pending_(rest_),
      shown_(rest_),
      scratch_(rest_),
      live_{rest_},
      before_{rest_} {}

Verdict FaceGuard::Offer(const FlameParams& frame, int64_t time_ns) {
  const int64_t newest_ns = has_pending_ ? pending_time_ns_ : shown_time_ns_;
  const Verdict verdict = time_ns < newest_ns ? Verdict::kLate : Judge(frame);
  if (verdict != Verdict::kAccepted) {
    CountRefused(verdict);
    return verdict;
  }
  if (has_pending_ && time_ns > pending_time_ns_) ++counts_.replaced;
  CopyFace(frame, pending_);
  pending_time_ns_ = time_ns;
  has_pending_ = true;
  return verdict;
}

void FaceGuard::CountRefused(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      break;
    case Verdict::kLate:
      ++counts_.late;
      break;
    case Verdict::kNotFinite:
      ++counts_.not_finite;
      break;
    case Verdict::kOutOfRange:
      ++counts_.out_of_range;
      break;
    case Verdict::kWrongSize:
      ++counts_.wrong_size;
      break;
  }
}

// The weight of the course's face against rest: 1 while it is held, 0 when it has decayed.
float FaceGuard::ShareOfLive(const Course& course, int64_t now_ns) const {
  if (course.began_ns == kNever) return 0;
  const double age = SecondsSince(course.began_ns, now_ns);
  return 1 - math::Ease(float((age - policy_.hold) / policy_.decay));
}

void FaceGuard::BlendFace(int64_t now_ns, FlameParams& out) {
  BlendFaces(rest_, live_.face, ShareOfLive(live_, now_ns), out);
  if (return_ns_ == kNever) return;
  const float returned = float(SecondsSince(return_ns_, now_ns) / policy_.blend_in);
  if (returned >= 1) {
    return_ns_ = kNever;
    return;
  }
  BlendFaces(rest_, before_.face, ShareOfLive(before_, now_ns), scratch_);
  BlendFaces(scratch_, out, math::Ease(returned), out);
}

// Starts blending from what was shown, which continues to decay while it fades out.
void FaceGuard::BeginReturn(int64_t now_ns) {
  if (return_ns_ == kNever) {
    std::swap(before_, live_);
  } else {  // during the previous return
    BlendFace(now_ns, shown_);
    CopyFace(shown_, before_.face);
    before_.began_ns = now_ns;
  }
  return_ns_ = now_ns;
  ++counts_.returned;
}

void FaceGuard::SmoothPending(int64_t now_ns) {
  if (!policy_.smoothing) return;
  // Uses the senders' timestamps, which are free of network jitter, or else the local clock.
  const bool timed = shown_time_ns_ != kNever && pending_time_ns_ > shown_time_ns_;
  const double dt =
      timed ? SecondsSince(shown_time_ns_, pending_time_ns_) : SecondsSince(live_.began_ns, now_ns);
  smoother_.Smooth(*policy_.smoothing, float(dt), pending_);
}

void FaceGuard::TakeUp(int64_t now_ns) {
  has_pending_ = false;
  ++counts_.accepted;
  if (policy_.soft_range && range_.Bring(pending_)) ++counts_.softened;
  // A face is blended in only if an earlier image showed it decaying, so that a host that calls At
  // rarely still shows every frame unchanged.
  const bool away = now_ns_ != kNever && ShareOfLive(live_, now_ns_) < 1;
  if (away) {
    smoother_.Reset();
    BeginReturn(now_ns);
  }
  SmoothPending(now_ns);
  CopyFace(pending_, live_.face);
  live_.began_ns = now_ns;
  shown_time_ns_ = pending_time_ns_;
}

const FlameParams& FaceGuard::At(int64_t now_ns) {
  now_ns = std::max(now_ns, now_ns_);
  const bool fresh = has_pending_;
  if (has_pending_) TakeUp(now_ns);
  now_ns_ = now_ns;
  BlendFace(now_ns, shown_);
  const float share = ShareOfLive(live_, now_ns);
  if (live_.began_ns == kNever || share == 0)
    state_ = FaceState::kRest;
  else if (share < 1)
    state_ = FaceState::kDecaying;
  else
    state_ = return_ns_ == kNever ? FaceState::kLive : FaceState::kReturning;
  if (!fresh && live_.began_ns != kNever) ++(share < 1 ? counts_.decayed : counts_.held);
  return shown_;
}

double FaceGuard::Age() const {
  return live_.began_ns == kNever ? -1 : SecondsSince(live_.began_ns, now_ns_);
}

void FaceGuard::Reset() {
  has_pending_ = false;
  pending_time_ns_ = shown_time_ns_ = now_ns_ = return_ns_ = kNever;
  live_.began_ns = before_.began_ns = kNever;
  state_ = FaceState::kRest;
  smoother_.Reset();
  CopyFace(rest_, shown_);
}

void FaceGuard::SetPolicy(const GuardPolicy& policy) {
  policy_ = policy;
  smoother_.Reset();
}

}  // namespace cosplat

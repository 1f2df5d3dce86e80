// The policy for bad frames: what a live face does when its parameters are late, wrong or missing.
//
// LiveSource::Poll or a host -> FaceGuard::Offer -> [SoftRange] -> [FaceSmoother] -> FaceGuard::At,
// once per image -> Player::Pose.
//
//   frames arrive            each is shown as it is
//   none for `hold`          the last good one is held
//   none after that          eases to rest within `decay`, without a jump in value or speed
//   frames arrive again      blended in over `blend_in` from whatever was shown
//
// Times are in nanoseconds by one clock that does not run backwards. Nothing is allocated after
// construction. The same calls give the same bits.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "avatar/live/smoother.h"
#include "avatar/live/soft_range.h"
#include "avatar/model/avatar_model.h"
#include "flame/model.h"

namespace cosplat {

// Numbers of larger magnitude belong to no face: FLAME's coefficients are in standard deviations,
// the other parameters in radians and metres.
constexpr float kMaxParameter = 100;
// More coefficients than any model has.
constexpr size_t kMaxExpressions = 65536;

struct GuardPolicy {
  // Seconds. A face that went to rest between two frames never jumps to the next one. If blend_in
  // is longer than hold, a second gap may begin during the blend; then only the value is
  // continuous, not the speed.
  double hold = 0.25, decay = 1, blend_in = 0.2;
  bool soft_range = true;
  std::optional<math::OneEuro> smoothing{};
};

enum class Verdict { kAccepted, kLate, kNotFinite, kOutOfRange, kWrongSize };

struct GuardCounts {
  uint64_t accepted = 0;      // good frames that were shown
  uint64_t replaced = 0;      // good, but superseded by a newer one before the next image
  uint64_t late = 0;          // refused: older than an earlier good frame
  uint64_t not_finite = 0;    // refused
  uint64_t out_of_range = 0;  // refused: beyond kMaxParameter
  uint64_t wrong_size = 0;    // refused
  uint64_t softened = 0;      // shown frames of which some part was outside SoftRange
  uint64_t held = 0;          // images without a new frame that show the last one
  uint64_t decayed = 0;       // images without a new frame, easing to rest or at rest
  uint64_t returned = 0;      // how often frames arrived again after that
};

enum class FaceState { kRest, kLive, kDecaying, kReturning };

class FaceGuard {
 public:
  // rest: the face shown without frames; the size of its expression is the number of coefficients.
  FaceGuard(FlameParams rest,
            const std::optional<TrainedRange>& trained,
            const GuardPolicy& policy = {});

  // Hands in a frame and its timestamp. A refused frame is counted and changes nothing. Of several
  // frames between two images the last is shown; those with equal times count as one. Missing
  // coefficients count as zero; those that the model does not have are ignored.
  Verdict Offer(const FlameParams& frame, int64_t time_ns);
  // Counts a frame that was refused by the caller.
  void CountRefused(Verdict verdict);

  // Returns the face at `now_ns`, valid until the next call. A time earlier than the previous one
  // counts as the previous one. The face is at rest until the first frame; a frame that arrives
  // before the first image is shown at once.
  const FlameParams& At(int64_t now_ns);

  // Returns to rest and accepts any time again; counts and policy are kept.
  void Reset();
  // Restarts smoothing.
  void SetPolicy(const GuardPolicy& policy);

  const GuardPolicy& policy() const { return policy_; }
  const GuardCounts& counts() const { return counts_; }
  FaceState state() const { return state_; }
  // Seconds from the last new frame shown to the last At; -1 if none was shown.
  double Age() const;

 private:
  static constexpr int64_t kNever = std::numeric_limits<int64_t>::min();

  // A face that is held from began_ns on and then decays.
  struct Course {
    FlameParams face;
    int64_t began_ns = kNever;
  };

  void TakeUp(int64_t now_ns);
  void BeginReturn(int64_t now_ns);
  void SmoothPending(int64_t now_ns);
  void BlendFace(int64_t now_ns, FlameParams& out);
  float ShareOfLive(const Course& course, int64_t now_ns) const;

  GuardPolicy policy_;
  SoftRange range_;
  FaceSmoother smoother_;
  FlameParams rest_, pending_, shown_, scratch_;
  bool has_pending_ = false;
  int64_t pending_time_ns_ = kNever, shown_time_ns_ = kNever;  // the frames' own timestamps
  int64_t now_ns_ = kNever;                                    // of the last At
  Course live_, before_;                                       // before_: blended out by a return
  int64_t return_ns_ = kNever;                                 // when frames arrived again
  FaceState state_ = FaceState::kRest;
  GuardCounts counts_;
};

}  // namespace cosplat

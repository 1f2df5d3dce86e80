// The rule for bad frames: what a live face does when its parameters are late, wrong or missing.
//
// LiveSource::Poll or a host -> FaceGuard::Offer -> [SoftRange] -> [FaceSmoother] -> FaceGuard::At,
// once per image -> Player::Place.
//
//   frames come              shown as they come
//   none for `hold`          the last good one stays
//   none after that          eases to rest within `decay`, without a jump in value or speed
//   they come again          eased in over `blend_in` from whatever was shown
//
// Times are in nanoseconds by one clock that does not run backwards. Nothing is allocated after
// construction. Same bits for the same calls.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "avatar/live/smoother.h"
#include "avatar/live/soft_range.h"
#include "avatar/model/avatar_model.h"
#include "flame/model.h"

namespace cosplat {

// Numbers further from zero than this are no face's: FLAME's coefficients are standard deviations,
// the rest is radians and metres.
constexpr float kMaxParameter = 100;
// More coefficients than any model has.
constexpr size_t kMaxExpressions = 65536;

struct GuardPolicy {
  // Seconds. A face that has gone to rest between two frames is never cut to the next one; where
  // blend_in is longer than hold, a second gap may begin within it, and only the value has no jump.
  double hold = 0.25, decay = 1, blend_in = 0.2;
  bool soft_range = true;
  std::optional<math::OneEuro> smoothing{};
};

enum class Verdict { kAccepted, kLate, kNotFinite, kOutOfRange, kWrongSize };

struct GuardCounts {
  uint64_t accepted = 0;      // good frames that were shown
  uint64_t replaced = 0;      // good, but a newer one came before the next image
  uint64_t late = 0;          // refused: older than one that was good
  uint64_t not_finite = 0;    // refused
  uint64_t out_of_range = 0;  // refused: beyond kMaxParameter
  uint64_t wrong_size = 0;    // refused
  uint64_t softened = 0;      // of those shown: some of it was out of SoftRange
  uint64_t held = 0;          // images without a new frame, the last one held
  uint64_t decayed = 0;       // images on the way to rest, or at rest after one
  uint64_t returned = 0;      // how often frames came again after that
};

enum class FaceState { kRest, kLive, kDecaying, kReturning };

class FaceGuard {
 public:
  // rest: where the face goes without frames; its expression gives the number of coefficients.
  FaceGuard(FlameParams rest,
            const std::optional<TrainedRange>& trained,
            const GuardPolicy& policy = {});

  // A frame that came in, and when it was so. What is refused is counted and changes nothing. Of
  // several between two images the last is shown; those of equal times are one frame. Missing
  // coefficients count as zero, those that the model lacks are left out.
  Verdict Offer(const FlameParams& frame, int64_t time_ns);
  // Counts a frame that was refused before it got here.
  void CountRefused(Verdict verdict);

  // The face at `now_ns`; an earlier one than before counts as the one before. Stays until the next
  // call. Before the first frame it is at rest; where that comes before the first image, it is
  // shown at once.
  const FlameParams& At(int64_t now_ns);

  // At rest, any time is new again; counts and policy stay.
  void Reset();
  // Smoothing begins anew.
  void SetPolicy(const GuardPolicy& policy);

  const GuardPolicy& policy() const { return policy_; }
  const GuardCounts& counts() const { return counts_; }
  FaceState state() const { return state_; }
  // Of the last At: seconds since a new frame was shown; -1: none was.
  double Age() const;

 private:
  static constexpr int64_t kNever = std::numeric_limits<int64_t>::min();

  // A face that is held from its time on and then decays.
  struct Course {
    FlameParams face;
    int64_t began_ns = kNever;
  };

  void TakeUp(int64_t now_ns);
  void BeginReturn(int64_t now_ns);
  void SmoothPending(int64_t now_ns);
  void Show(int64_t now_ns, FlameParams& out);
  float ShareOfLive(const Course& course, int64_t now_ns) const;

  GuardPolicy policy_;
  SoftRange range_;
  FaceSmoother smoother_;
  FlameParams rest_, pending_, shown_, scratch_;
  bool has_pending_ = false;
  int64_t pending_time_ns_ = kNever, shown_time_ns_ = kNever;  // by the frames' own times
  int64_t now_ns_ = kNever;                                    // of the last At
  Course live_, before_;                                       // before_: until it has returned
  int64_t return_ns_ = kNever;                                 // when frames came again
  FaceState state_ = FaceState::kRest;
  GuardCounts counts_;
};

}  // namespace cosplat

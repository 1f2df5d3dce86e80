// Two hours of a tracker's frames for an avatar, as far as one likes: one in a hundred bad, one in
// ten late, and every now and then none for a while. The same for the same frame number.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>

#include "avatar/plugin/cosplat.h"
#include "splat/base/rng.h"
#include "tests/support/restless_params.h"

namespace cosplat::test {

class LiveStory {
 public:
  static constexpr int64_t kStepNs = 33'333'333;  // 30 frames per second
  static constexpr int kDelay = 3;                // frames by which late ones come
  static constexpr int kAct = 2000, kPause = 80;  // frames; a pause ends every act

  explicit LiveStory(const FlameModel& flame) : flame_(flame) {}

  // What arrives before image `frame`; one call per frame, in order. False where the avatar took
  // it otherwise than it should.
  bool Feed(cosplat_avatar* avatar, int frame) {
    bool as_expected = true;
    const Arrival arrival = ArrivalOf(frame);
    if (arrival == Arrival::kGood) as_expected = Set(avatar, frame);
    if (arrival == Arrival::kBad) as_expected = SetSpoiled(avatar, frame);
    if (frame >= kDelay && ArrivalOf(frame - kDelay) == Arrival::kLate)
      as_expected = Set(avatar, frame - kDelay) && as_expected;
    return as_expected;
  }

  // The frame that was set last of those that were good and not late; -1: none.
  int newest() const { return newest_; }
  // Its coefficients are the story's own, until the next call.
  cosplat_parameters ParametersFor(int frame) {
    params_ = RestlessParams(flame_, frame);
    cosplat_parameters p;
    std::memset(&p, 0, sizeof(p));
    p.struct_size = sizeof(p);
    p.expression_count = uint32_t(params_.expression.size());
    p.expression = params_.expression.data();
    p.time_ns = frame * kStepNs;
    for (size_t j = 0; j < COSPLAT_JOINT_COUNT; ++j)
      std::memcpy(p.joints[j], params_.pose[j].data(), sizeof(p.joints[j]));
    std::memcpy(p.translation, params_.translation.data(), sizeof(p.translation));
    return p;
  }

  uint64_t bad() const { return bad_; }
  uint64_t late() const { return late_; }

 private:
  enum class Arrival { kGood, kBad, kLate, kNone };

  static Arrival ArrivalOf(int frame) {
    if (frame % kAct >= kAct - kPause) return Arrival::kNone;
    const uint64_t lot = Rng{uint64_t(frame)}.Below(100);
    return lot == 0 ? Arrival::kBad : lot <= 10 ? Arrival::kLate : Arrival::kGood;
  }

  bool Set(cosplat_avatar* avatar, int frame) {
    const cosplat_parameters p = ParametersFor(frame);
    const bool late = frame < newest_;
    late_ += late;
    if (!late) newest_ = frame;
    return cosplat_set_parameters(avatar, &p) == (late ? COSPLAT_ERROR_LATE : COSPLAT_OK);
  }

  bool SetSpoiled(cosplat_avatar* avatar, int frame) {
    cosplat_parameters p = ParametersFor(frame);
    ++bad_;
    switch (bad_ % 4) {
      case 0:
        p.joints[COSPLAT_JOINT_JAW][0] = std::nanf("");
        break;
      case 1:
        params_.expression[0] = std::numeric_limits<float>::infinity();
        break;
      case 2:
        p.translation[2] = 1e20f;
        break;
      default:
        p.expression_count = ~0u;
        break;
    }
    return cosplat_set_parameters(avatar, &p) != COSPLAT_OK;
  }

  const FlameModel& flame_;
  FlameParams params_;
  int newest_ = -1;
  uint64_t bad_ = 0, late_ = 0;
};

}  // namespace cosplat::test

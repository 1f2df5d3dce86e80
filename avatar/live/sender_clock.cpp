#include "avatar/live/sender_clock.h"

namespace cosplat {
bool SequenceFilter::Accept(uint64_t sequence, int64_t now_ns) {
  const bool older = any_ && sequence <= newest_;
  if (older && ElapsedNs(accepted_ns_, now_ns) < kRestartPauseNs) return false;
  any_ = true;
  began_again_ = older;
  newest_ = sequence;
  accepted_ns_ = now_ns;
  return true;
}

int64_t SenderClock::Received(int64_t sent_ns, int64_t now_ns) {
  const uint64_t difference = uint64_t(now_ns) - uint64_t(sent_ns);
  const int64_t passed = ElapsedNs(last_now_ns_, now_ns);
  if (any_ && passed > 0) difference_ += uint64_t(passed) / 1000;
  last_now_ns_ = now_ns;
  int64_t delay = int64_t(difference - difference_);
  if (!any_ || delay < 0 || delay > kMaxDelayNs) {
    difference_ = difference;
    delay = 0;
  }
  any_ = true;
  return int64_t(uint64_t(now_ns) - uint64_t(delay));
}

}  // namespace cosplat

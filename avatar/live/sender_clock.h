// What a sender's sequence numbers and timestamps say: which frame is new, and when it was so.
#pragma once

#include <cstdint>

namespace cosplat {

// Which frames are newer than all before. A sender that begins again, with lower numbers, is taken
// up again when no frame has been accepted for kRestartPauseNs.
class SequenceFilter {
 public:
  static constexpr int64_t kRestartPauseNs = 500'000'000;

  bool Accept(uint64_t sequence, int64_t now_ns);
  // Whether the last frame that was accepted is of a sender that began again.
  bool began_again() const { return began_again_; }

 private:
  bool any_ = false, began_again_ = false;
  uint64_t newest_ = 0;
  int64_t accepted_ns_ = 0;
};

// The sender's timestamps by the receiver's clock. The two clocks' difference is the least seen of
// (received - sent), as on the fastest way; it grows by a thousandth of the time that passes, so
// that a sender's clock that goes slow is followed. A frame that would be more than kMaxDelayNs
// old means that the sender's clock was set: its difference counts from then on.
class SenderClock {
 public:
  static constexpr int64_t kMaxDelayNs = 2'000'000'000;

  // When it was so, by the clock of `now_ns`; not after it.
  int64_t Received(int64_t sent_ns, int64_t now_ns);

 private:
  bool any_ = false;
  uint64_t difference_ = 0;  // receiver's clock less sender's, modulo 2^64
  int64_t last_now_ns_ = 0;
};

}  // namespace cosplat

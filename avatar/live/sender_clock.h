// Interprets a sender's sequence numbers and timestamps: which frames are new, and when they were
// captured by the receiver's clock.
#pragma once

#include <cstdint>

namespace cosplat {

// Modulo 2^64, so that no two times overflow.
inline int64_t ElapsedNs(int64_t from_ns, int64_t to_ns) {
  return int64_t(uint64_t(to_ns) - uint64_t(from_ns));
}

// Accepts frames that are newer than all before. A sender that restarts with lower numbers is
// accepted once no frame has been accepted for kRestartPauseNs.
class SequenceFilter {
 public:
  static constexpr int64_t kRestartPauseNs = 500'000'000;

  bool Accept(uint64_t sequence, int64_t now_ns);
  // Whether the last accepted frame is the first after a restart.
  bool began_again() const { return began_again_; }

 private:
  bool any_ = false, began_again_ = false;
  uint64_t newest_ = 0;
  int64_t accepted_ns_ = 0;
};

// Converts the sender's timestamps to the receiver's clock. The difference of the two clocks is
// estimated as the minimum of (received - sent), that is, from the fastest packet. The estimate
// grows by a thousandth of the elapsed time, to follow a sender's clock that runs slow. A frame
// that would be more than kMaxDelayNs old means that the sender's clock was set; the estimate then
// restarts from that frame.
class SenderClock {
 public:
  static constexpr int64_t kMaxDelayNs = 2'000'000'000;

  // The time of `sent_ns` by the receiver's clock; at most `now_ns`.
  int64_t Received(int64_t sent_ns, int64_t now_ns);

 private:
  bool any_ = false;
  uint64_t difference_ = 0;  // receiver's clock minus sender's, modulo 2^64
  int64_t last_now_ns_ = 0;
};

}  // namespace cosplat

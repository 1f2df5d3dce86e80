// Where a live face comes from: a recorded sequence, a tracker that sends, a camera program.
//
// "udp://..." -> OpenLiveSource -> LiveSource::Poll, once per image -> LiveFrame -> who draws.
// A source gives clean frames only: what is malformed, too large, too much or not finite is dropped
// and counted, and never reaches the face.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "flame/model.h"

namespace cosplat {

struct LiveFrame {
  // Expression, pose and translation, the root about LiveSourceOptions::rest; `shape` and
  // `static_offset` are empty.
  FlameParams params;
  uint64_t sequence = 0;  // the sender's number
  int64_t time_ns = 0;    // when it was so, by the clock that Poll is given
};

// What came in since the source was opened.
struct LiveCounts {
  uint64_t frames = 0;       // given by Poll
  uint64_t replaced = 0;     // good, but a newer one had come before Poll asked
  uint64_t reordered = 0;    // older than, or the same as, one that came before
  uint64_t malformed = 0;    // not what the protocol says, or not finite
  uint64_t oversize = 0;     // longer than the protocol allows
  uint64_t flooded = 0;      // more between two polls than are looked at
  std::string last_problem;  // one line about the last packet that was dropped; "" if none was
};

class LiveSource {
 public:
  virtual ~LiveSource() = default;
  // The newest frame since the last call; of a recording the one that is due. Never waits. False,
  // and `out` as it was, where there is none. `now_ns`: any clock that does not run backwards; a
  // recording begins at the first call.
  virtual bool Poll(int64_t now_ns, LiveFrame& out) = 0;
  // True when nothing will come any more: the end of a recording or of standard input.
  virtual bool Ended() const = 0;
  virtual LiveCounts Counts() const = 0;
  // For people: "recorded sequence talk.npz, 250 frames", "udp://127.0.0.1:9500".
  virtual std::string Description() const = 0;
};

struct LiveSourceOptions {
  // Where the avatar's head rests, as root pose and translation (RestRoot of
  // avatar/model/avatar_mesh.h): a recording turns about it as it did about its own mean, a
  // tracker's root counts from it.
  FlameParams rest;
  bool loop = false;             // recordings begin again at their end
  double frames_per_second = 0;  // of a recording; 0: its own, or 25 where it does not say
};

// drive: a file or folder that LoadDrivingSequence reads, or "stdin:", "udp://HOST:PORT" (FLAME
// parameters as JSON lines), "vmc://HOST:PORT?matrix=FILE" (blendshapes over OSC). HOST may be left
// out: loopback. Throws Error naming the drive and what is wrong with it.
std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options = {});

}  // namespace cosplat

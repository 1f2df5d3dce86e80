// Sources of live faces: a recorded sequence, a tracker that sends, or a camera program.
//
// "udp://..." -> OpenLiveSource -> LiveSource::Poll, once per image -> LiveFrame -> FaceGuard.
// A source delivers clean frames only: what is malformed, too large, too many or not finite is
// dropped and counted, and never reaches the face.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "avatar/live/unused_input.h"
#include "avatar/model/blendshape_map.h"
#include "flame/model.h"

namespace cosplat {

struct LiveFrame {
  // Expression, pose and translation; the root includes LiveSourceOptions::rest. `shape` and
  // `static_offset` are empty.
  FlameParams params;
  uint64_t sequence = 0;  // the sender's number
  int64_t time_ns = 0;    // when it was captured, by the clock passed to Poll
};

// Counts since the source was opened.
struct LiveCounts {
  uint64_t packets = 0;      // that arrived, whatever was in them; 0 if nothing sends to this port
  uint64_t unusable = 0;     // of them well-formed, but without anything that moves the face
  uint64_t frames = 0;       // returned by Poll
  uint64_t replaced = 0;     // good, but superseded by a newer one before the next Poll
  uint64_t reordered = 0;    // older than, or the same as, an earlier one
  uint64_t malformed = 0;    // packets, or parts that were dropped from them: not as the protocol
                             // requires, or not finite
  uint64_t oversize = 0;     // longer than the protocol allows
  uint64_t flooded = 0;      // discarded because too many arrived between two polls
  std::string last_problem;  // one line about the last dropped packet; "" if there was none
  UnusedInput unused;        // by name
  std::string senders;       // two that take turns: "127.0.0.1:5000 and 127.0.0.1:5001"; or ""
};

// One line: what arrived and was not used, by name, and whether several send; "" if there is
// nothing to say.
std::string NotesOf(const LiveCounts& counts);
// One line of all counts that are not zero, and the notes.
std::string ToString(const LiveCounts& counts);

class LiveSource {
 public:
  virtual ~LiveSource() = default;
  // Writes the newest frame since the last call, or of a recording the one that is due. Never
  // blocks. Returns false and leaves `out` unchanged when there is none. now_ns: from any clock
  // that does not run backwards; a recording starts at the first call.
  virtual bool Poll(int64_t now_ns, LiveFrame& out) = 0;
  // True when no more frames will come: at the end of a recording or of standard input.
  virtual bool Ended() const = 0;
  virtual LiveCounts Counts() const = 0;
  // Human-readable: "recorded sequence talk.npz, 250 frames at 25 per second",
  // "udp://127.0.0.1:9500".
  virtual std::string Description() const = 0;
};

struct LiveSourceOptions {
  // Root pose and translation of the avatar's head at rest (RestRoot of
  // avatar/model/avatar_mesh.h). A recording moves about it as it did about its own mean; a
  // tracker's root is relative to it.
  FlameParams rest;
  // The avatar's; needed for recordings whose tracker moved the camera about a fixed head
  // (TrackedVideo::head_is_fixed), and for blendshapes to close eyelids without a map. Used only
  // while a source is opened.
  const FlameModel* flame = nullptr;
  // The avatar's map from blendshape scores, or null; used where the drive names no matrix. Copied
  // when a source is opened.
  const BlendshapeMap* blendshapes = nullptr;
  bool loop = false;             // repeat recordings
  double frames_per_second = 0;  // of a recording; 0: its own rate, or 25 if unknown
  std::string program;  // the file of the command cosplat, which "webcam:" and "audio:" are of; "":
                        // that of PATH
};

// drive: a file or folder that LoadRecording reads, or "webcam:", "webcam:N" (this machine's
// cameras), "audio:" (its microphone), "stdin:", "udp://HOST:PORT" (FLAME parameters or blendshape
// scores as JSON lines), "vmc://HOST:PORT" (scores over OSC), "vts://PHONE", "ifacialmocap://PHONE"
// and "livelink://HOST" (apps on phones; a port may follow). Those with "://" may end in
// "?matrix=FILE", which is then used instead of the avatar's map, and those of phones in
// "?flip=AXES", x, y and z, which turns the head the other way about these. HOST may be omitted and
// is then loopback. Throws Error naming the drive and what is wrong with it.
std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options = {});

// True for what OpenLiveSource takes from somewhere else than a recording.
bool IsLiveDrive(const std::string& drive);

// Lines of JSON, as those of "stdin:", from a descriptor, which must stay open as long and is not
// closed.
std::unique_ptr<LiveSource> OpenLineSource(int descriptor,
                                           const std::string& description,
                                           const LiveSourceOptions& options);

}  // namespace cosplat

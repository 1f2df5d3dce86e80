// What must hold of a live source whatever it is sent: checked by the mutation tests and by the
// fuzzers.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "avatar/live/guard.h"
#include "avatar/live/packet_input.h"

namespace cosplat::test {

// Hands over packets as a socket would.
class MemoryInput : public PacketInput {
 public:
  explicit MemoryInput(const std::string* packet) : packet_(packet) {}
  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    if (packet_->size() > kMaxPacketBytes) {
      CountOversize("memory", packet_->size(), counts);
    } else {
      packets.Push(*packet_);
    }
  }
  bool Ended() const override { return false; }
  std::string Description() const override { return "memory"; }

 private:
  const std::string* packet_;  // of the next call
};

// What is wrong with a frame, or "".
inline std::string FrameProblem(const FlameParams& params) {
  const auto bad = [](float x) { return !(std::abs(x) <= kMaxParameter); };
  for (const float x : params.expression)
    if (bad(x)) return "expression holds " + std::to_string(x);
  for (const auto& joint : params.pose)
    for (const float x : joint)
      if (bad(x)) return "pose holds " + std::to_string(x);
  for (const float x : params.translation)
    if (bad(x)) return "translation holds " + std::to_string(x);
  return "";
}

// Polls once; what is wrong with what came of it, or "".
inline std::string PollProblem(LiveSource& source, int64_t now_ns, bool& good) {
  const LiveCounts before = source.Counts();
  LiveFrame frame;
  good = source.Poll(now_ns, frame);
  const LiveCounts after = source.Counts();
  if (after.last_problem.find('\n') != std::string::npos) return "a problem of two lines";
  if (after.last_problem.size() > 400) return "a problem without an end";
  const std::string notes = NotesOf(after);
  if (notes.size() > 8000) return "notes without an end";
  if (std::any_of(notes.begin(), notes.end(), [](char c) { return c < ' ' || c > '~'; }))
    return "notes that cannot be printed";
  if (good) return frame.time_ns > now_ns ? "a frame of the future" : FrameProblem(frame.params);
  const bool counted = after.malformed + after.oversize + after.reordered >
                       before.malformed + before.oversize + before.reordered;
  if (counted && after.last_problem.empty()) return "a packet dropped without a word";
  return "";
}

}  // namespace cosplat::test

// A frame of FLAME parameters as a line of JSON: the protocol of docs/live-input.md.
//
// a tracker, `cosplat send` -> UDP or standard input -> ParseJsonFrame -> JsonSource.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "flame/model.h"

namespace cosplat {

struct JsonFrame {
  uint64_t sequence = 0;
  std::optional<double> time;  // seconds by the sender's clock
  FlameParams params;          // the root counts from the avatar's rest; what is not there is zero
};

// Throws Error(source, field, ...) when it is not one frame: a field is unknown, has another count
// of numbers, or a number that is not finite or beyond 100.
JsonFrame ParseJsonFrame(const std::string& source, const std::string& line);

// One line without its end.
std::string WriteJsonFrame(const JsonFrame& frame);

}  // namespace cosplat

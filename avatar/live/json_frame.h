// A frame of FLAME parameters as a line of JSON: the protocol in docs/live-input.md.
//
// a tracker, `cosplat send` -> UDP or standard input -> ParseJsonFrame -> JsonSource.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "avatar/model/blendshape_map.h"
#include "flame/model.h"

namespace cosplat {

struct JsonFrame {
  uint64_t sequence = 0;
  std::optional<double> time;  // seconds by the sender's clock
  FlameParams params;          // the root is relative to the avatar's rest; absent fields are zero
  std::optional<BlendshapeScores> blendshapes;  // in place of expression, jaw and eyes
  // Names of scores that were left out: not a number (NaN is null in JSON), or beyond kMaxScore.
  std::vector<std::string> dropped;
};

// Throws Error(source, field, ...) when the line is not one frame: a field is unknown or has a
// wrong count of numbers, a number is not finite or beyond 100, or it has both blendshapes and what
// they determine. A bad score costs only itself.
JsonFrame ParseJsonFrame(const std::string& source, const std::string& line);

// Returns one line without its newline.
std::string WriteJsonFrame(const JsonFrame& frame);

}  // namespace cosplat

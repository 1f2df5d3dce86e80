// What a check of a data set found, before it is trained on: splat/io/scene_check.h for scenes,
// flame/track_check.h for heads; `cosplat check` and the trainers print them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace cosplat {

struct Finding {
  bool wrong = false;  // it trains, but not what the user meant; else worth knowing
  std::string text;    // one sentence: the figure, and what to do
};

inline bool AnyWrong(const std::vector<Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.wrong; });
}

}  // namespace cosplat

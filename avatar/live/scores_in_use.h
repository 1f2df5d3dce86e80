// Which of several kinds of values a VMC sender means, for VmcSource.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "avatar/live/sender_clock.h"
#include "avatar/model/blendshape_map.h"

namespace cosplat {

// Whether some scores are in use: one was above zero a while ago at most. Senders of several kinds
// of values often send one of them as zeros.
class ScoresInUse {
 public:
  explicit ScoresInUse(std::vector<size_t> places) : places_(std::move(places)) {}
  // scores: of a frame at that time.
  bool Are(const std::vector<float>& scores, int64_t now_ns) {
    for (const size_t c : places_)
      if (scores[c] > kUsed) {
        seen_ = true;
        seen_ns_ = now_ns;
      }
    return seen_ && ElapsedNs(seen_ns_, now_ns) < kPauseNs;
  }

 private:
  static constexpr float kUsed = 0.01f;  // of a gaze, less than half a degree
  // Nobody looks straight ahead, or keeps a face so still, for so long.
  static constexpr int64_t kPauseNs = 2'000'000'000;

  std::vector<size_t> places_;
  bool seen_ = false;
  int64_t seen_ns_ = 0;
};

// Of the scores that turn eyes. Where they and the eyes' bones move, scores count: they are the
// tracker's own, while the bones are limited to what suits the sender's model.
inline std::vector<size_t> PlacesOfGaze(const BlendshapeMap& map) {
  std::vector<size_t> places;
  const size_t width = map.offset.size(), eyes = map.expression_count() + 3;  // after the jaw
  for (size_t c = 0; c < map.names.size(); ++c) {
    const float* row = &map.matrix[c * width];
    const bool turns = std::any_of(row + eyes, row + width, [](float x) { return x != 0; });
    if (turns && ArkitSpelling(map.names[c]).starts_with("eyeLook")) places.push_back(c);
  }
  return places;
}

inline std::vector<size_t> AllPlaces(const BlendshapeMap& map) {
  std::vector<size_t> places(map.names.size());
  std::iota(places.begin(), places.end(), size_t(0));
  return places;
}

}  // namespace cosplat

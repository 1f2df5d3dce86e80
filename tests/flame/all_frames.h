// Training and test frames together.
#pragma once

#include <vector>

#include "flame/track.h"

namespace cosplat::test {

inline std::vector<TrackedFrame> AllFrames(const TrackedVideo& video) {
  std::vector<TrackedFrame> all = video.train;
  all.insert(all.end(), video.test.begin(), video.test.end());
  return all;
}

}  // namespace cosplat::test

// What is behind a person, seen past them in the other frames of a video whose camera stands still.
//
// MatteRefiner (refine_mattes.h) tells by it what is in front.
#pragma once

#include <vector>

#include "splat/base/image.h"

namespace cosplat {

struct StillBackground {
  Image color;  // RGB [0, 1]
  // 1 channel: standard deviation of a pixel's colour (its worst channel) that the frames show, in
  // [0, 1]; negative where the background is not known: seen in too few frames, or not the same in
  // them.
  Image noise;
};

// Per pixel the median over `frames` (RGB, all of one size) of those whose `clear` (1 channel) is
// not 0 there.
StillBackground FindStillBackground(const std::vector<Image8>& frames,
                                    const std::vector<Image8>& clear);

// 1 channel, 1 where something stands still in all `frames` that the network does not take for the
// person in all of them, as a lectern: of at least 2 radius + 1 px, so that the rim of somebody who
// stands still is none. Rows that it covers half of what `mattes` (1 channel) have there are its
// own altogether, except for what moves.
Image8 FindStillThings(const std::vector<Image8>& frames,
                       const std::vector<Image8>& mattes,
                       int radius);

}  // namespace cosplat

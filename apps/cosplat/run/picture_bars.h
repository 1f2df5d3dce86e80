// Bars beside a video's picture, as programs add them to fill a frame of another shape: black, or
// the picture itself, enlarged and blurred.
#pragma once

#include <optional>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// The part of frames between two bars of one width, to the left and right or above and below; all
// of it if there are none. Nothing if the frames are too dark or soft to tell. A bar ends in a
// straight edge through the whole frame, and has little detail. frames: some, of one size and 3
// channels.
std::optional<Crop> PictureBetweenBars(const std::vector<Image8>& frames);

}  // namespace cosplat

// Where in a video is the head? One part for all of its frames, from the faces in some of them.
#pragma once

#include <array>
#include <vector>

#include "flame/io/landmarks.h"

namespace cosplat {

// The part that holds the face of each frame, in all but the outermost 2 % of its places, with room
// for hair and shoulders: a square, of which only what is beyond the frame is missing. faces:
// [frames] of one person, or none (KeepPerson), px of a frame of width x height. size: px; as an
// image the part has no more pixels than a square of this side, and no more than it has in the
// frame. Throws Error if no frame has a face.
FrameCrop HeadCrop(const std::vector<std::vector<DetectedFace>>& faces,
                   int width,
                   int height,
                   int size);

// Sides of a part of a frame as an image of no more pixels than a square of this side, px.
std::array<int, 2> SidesWithin(const Crop& part, int size);

}  // namespace cosplat

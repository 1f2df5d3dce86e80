// Where in a video is the head? One square for all of its frames, from the faces in some of them.
#pragma once

#include <vector>

#include "flame/io/landmarks.h"

namespace cosplat {

// The square that holds the largest face of each frame, in all but the outermost 2 % of its places,
// with room for hair and shoulders; as large as the frame allows. faces: [frames] of all that were
// found, px of a frame of width x height. size: px, of the square as an image, which is no larger
// than the square is in the frame. Throws Error if no frame has a face.
FrameCrop HeadCrop(const std::vector<std::vector<DetectedFace>>& faces,
                   int width,
                   int height,
                   int size);

}  // namespace cosplat

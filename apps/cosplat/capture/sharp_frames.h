// The frames of a video that stand for it as photographs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// Variance of the Laplacian of the green channel (Pech-Pacheco et al. 2000): comparable between
// images of the same scene and size, where motion blur lowers it. 0 for images under 3x3 px.
double Sharpness(const Image8& image);

// Splits the video into `count` intervals of equal length (fewer if it has fewer frames), and
// writes the sharpest frame of each to folder/frame_NNNNNN.jpg, by its number in the video. Returns
// the names, in order. `progress` is called with the frames read and their number. Throws Error as
// VideoReader does.
std::vector<std::string> WriteSharpFrames(const std::string& video,
                                          int count,
                                          const std::string& folder,
                                          const std::function<void(int done, int total)>& progress);

}  // namespace cosplat

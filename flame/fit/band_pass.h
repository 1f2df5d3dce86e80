// Frames as the photometric part of the track's fit compares them. Private to flame/fit/.
#pragma once

#include <array>

#include "splat/base/image.h"

namespace cosplat::internal {

// A part of a frame: brightness without what varies slowly, such as shading, and without single
// pixels' noise, in 8-bit levels.
struct BandPassed {
  double scale = 1;                // its pixels per pixel of the frame
  std::array<double, 2> corner{};  // of its first pixel, in pixels of the frame
  Image image;                     // [height, width, 1]
};

// frame: RGB, or RGBA with a matte, outside of which nothing counts: a background stands still
// while the head moves before it. box: left, top, right, bottom in px of the frame; is clipped.
// scale: to be at most 1, and such that a face has about kBandPassFace pixels.
constexpr double kBandPassFace = 160;
BandPassed BandPass(const Image8& frame, const std::array<double, 4>& box, double scale);

struct BrightnessAt {
  double value = 0, d_x = 0, d_y = 0;  // levels; levels per px of the frame
  bool inside = false;                 // of the part; otherwise all are zero
};
// Bilinear. x, y: px of the frame.
BrightnessAt SampleAt(const BandPassed& image, double x, double y);

}  // namespace cosplat::internal

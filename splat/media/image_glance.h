// An image at a glance: what the checks of a data set compare instead of the image itself.
#pragma once

#include <array>
#include <cstdint>

#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat {

// At most `side` px wide and high, each pixel the mean of the pixels that it covers. An image that
// fits is returned as it is.
Image8 ReducedTo(const Image8& image, int side);

// RGB: what is transparent is black.
Image8 OverBlack(const Image8& image);

// Brightness of an 8x8 reduction, over the whole image.
using Glance = std::array<uint8_t, 64>;
Glance GlanceOf(const Image8& image);

// Mean difference, 0 to 255.
double DifferenceOf(const Glance& a, const Glance& b);

// Standard deviation of the brightness, 0 to 255, of the pixels that are more opaque than not; 0 if
// there are none.
double ContrastOf(const Image8& image);

// The greatest alpha; 255 of an image without.
int GreatestAlpha(const Image8& image);
int SmallestAlpha(const Image8& image);  // likewise

// Where the camera sees a point: its place in the camera's axes, and px. p_in_world: [3].
struct Sighting {
  std::array<float, 3> in_camera;
  float x, y;
  bool inside;  // of the image, in front of the camera
};
Sighting Sight(const Camera& camera, const float* p_in_world);

}  // namespace cosplat

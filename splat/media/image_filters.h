// Filters of images of floats: what refining a matte is made of (refine_mattes.h).
#pragma once

#include <cstdint>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// Means over squares of 2 radius + 1 px; the image is mirrored beyond its rims. Any number of
// channels.
Image BoxMean(const Image& image, int radius);

// 1 where `mask` (1 channel, 0 or 1) is 1 within such a square.
Image Dilated(const Image& mask, int radius);

// Which of a mask's parts a pixel is in. Parts are 4-connected.
struct ConnectedParts {
  int count = 0;            // parts are numbered from 1
  std::vector<int> labels;  // [height, width]; 0 where the mask is 0
};
ConnectedParts PartsOf(const Image8& mask);

// The guided filter of a colour image (He, Sun, Tang: Guided image filtering, 2013, eq. 14 to 16)
// with a weight per pixel: in each square of 2 radius + 1 px `input` (1 channel) is fitted as a
// linear function of the colours of `guide` (3 channels, [0, 1]) by least squares, weighted by
// `weight` (1 channel, >= 0); each pixel gets the mean of the functions of the squares around it.
// epsilon: of the ridge, square of a contrast that counts as an edge.
Image GuidedFilter(
    const Image& guide, const Image& input, const Image& weight, int radius, float epsilon);

}  // namespace cosplat

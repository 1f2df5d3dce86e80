// What a face looks like in a frame: how sharp, in which colours.
#pragma once

#include <array>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// How sharp a face is: the mean square of its image's Laplacian, within the landmarks' extent. To
// be compared within a video. image: 3 channels. landmarks: px.
double SharpnessOf(const Image8& image, const std::vector<std::array<double, 2>>& landmarks);

// Mean colours of the parts of a face, 4 by 4 within the landmarks' extent, one after the other: 48
// numbers of [0, 255], or -1 for parts beyond the image. image: 3 channels. landmarks: px.
std::vector<float> FaceColorsOf(const Image8& image,
                                const std::vector<std::array<double, 2>>& landmarks);

// Mean difference of the colours of the parts that both show, of [0, 255]; 0 if there is none.
double FaceColorChange(const std::vector<float>& a, const std::vector<float>& b);

// Faces whose colours differ by more are of other people, or in another light. Four people's
// frames differ by up to 5 from the nearest ones of the same person, and by 19 from any of another.
constexpr double kOtherFace = 12;

// Where a face looks different from there on: in another shot, of another person, in another light.
// colors: of frames in order, FaceColorsOf. Nothing where the face changes as much all the time.
std::vector<size_t> OtherLooks(const std::vector<std::vector<float>>& colors);

}  // namespace cosplat

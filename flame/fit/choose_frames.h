// Which frames of a long video are worth training on: those that differ.
//
// FramesToLookAt -> landmarks of these -> ChooseFrames.
#pragma once

#include <vector>

#include "flame/io/landmarks.h"

namespace cosplat {

// Frames of a video that are looked at, and how many of them, at the end, are for testing.
struct FrameSelection {
  std::vector<size_t> frames;  // increasing
  int held_out = 0;            // 0: nobody said
};

// For a choice of `wanted` frames (0: all) of `total`: all of them if there are no more. Else the
// last fifth of the choice are the video's last moments, one after the other at 30 frames a second
// at most, the second before them is left out, and the others are twice as many as will be chosen,
// spread evenly. rate: frames per second.
FrameSelection FramesToLookAt(size_t total, int wanted, double rate);

// Of `seen.frames`, of which the last `seen.held_out` are kept, the others' best until there are
// `wanted`: half of them spread evenly over the video, half each the one whose face differs most
// from those that are chosen (landmarks about their middle in units of the face's size, and
// ScoresOf). Frames without a face and the least sharp ones come last. sharpness: [frames]; 0
// without a face. Returns indices into seen.frames, increasing.
std::vector<size_t> ChooseFrames(const LandmarkVideo& seen,
                                 const std::vector<double>& sharpness,
                                 int wanted);

}  // namespace cosplat

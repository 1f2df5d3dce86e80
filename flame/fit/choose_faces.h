// One face per frame from all that a detector saw: the largest, and then the same one.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "flame/io/landmarks.h"
#include "splat/base/skipped.h"

namespace cosplat {

struct ObservedFace {
  std::vector<std::array<double, 2>> points;  // px
  std::vector<double> weights;                // per point, 0 to 1: 0 for the iris of a closed eye
  double size = 0;                            // px, side of a square of the face's area
  bool follows = false;  // the frame just before shows this face, too; false after a cut
  double seconds = 0;    // when, from the video's beginning
};

struct ChosenFaces {
  std::vector<std::optional<ObservedFace>> faces;  // [frames]
  std::vector<SkippedFrame> skipped;               // frames without a face
  int cuts = 0;  // how often the face jumps, or another one takes its place, from frame to frame
};

// Throws Error if no frame has a face, or fewer than two thirds do (CheckSkipped).
ChosenFaces ChooseFaces(const LandmarkVideo& video);

}  // namespace cosplat

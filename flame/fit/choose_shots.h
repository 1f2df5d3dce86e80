// Of a video that is cut: which of its shots show one person from one distance?
//
// FindCuts (splat/media/frame_cuts.h) -> ShotsBetween -> SampleShots -> faces in these frames ->
// ShotsAlike.
#pragma once

#include <cstddef>
#include <vector>

namespace cosplat {

// Frames from `begin` to before `end`.
struct Shot {
  int begin = 0, end = 0;
  int count() const { return end - begin; }
};

// cuts: where shots begin, increasing, without 0. What is shorter than a sixth of a second is left
// out, if anything is longer. rate: frames per second.
std::vector<Shot> ShotsBetween(const std::vector<int>& cuts, int frame_count, double rate);

// `count` frames or some more, spread evenly over the shots, at least two of each that has as many.
// Increasing.
std::vector<int> SampleShots(const std::vector<Shot>& shots, int count);

// The face of a frame.
struct FaceLook {
  int frame = 0;
  double size = 0;            // px, of the whole frame
  std::vector<float> colors;  // FaceColorsOf
};

// The places in `shots`, increasing, of those that are alike and have the most frames. Two shots
// are alike if some frames of both show a face of one size and in the same colours, or if both are
// like a third. A shot without a face is like none. Empty if no shot has a face.
std::vector<size_t> ShotsAlike(const std::vector<Shot>& shots, const std::vector<FaceLook>& looks);

}  // namespace cosplat

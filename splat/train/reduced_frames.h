// Training frames at a fraction of their size, for the first steps of a run
// (Schedule::DownscaleAt).
#pragma once

#include <vector>

#include "splat/train/subject.h"

namespace cosplat {

// Its sides divided by `downscale`: means of blocks, weighted by alpha where there is one. What is
// left over at the right and the bottom is cut off, so that the camera is exact.
TrainFrame Reduced(const TrainFrame& frame, int downscale);

// Those of a subject, which must outlive it. Keeps the ones of the last downscale asked for.
class ReducedFrames {
 public:
  explicit ReducedFrames(const Subject& subject) : subject_(subject) {}

  // Frame i; the subject's own where downscale is 1. Borrowed until another downscale is asked for.
  const TrainFrame& At(size_t i, int downscale);
  size_t held() const { return held_; }  // bytes

 private:
  const Subject& subject_;
  int downscale_ = 1;
  std::vector<TrainFrame> reduced_;  // [frames] empty images: not yet
  size_t held_ = 0;
};

}  // namespace cosplat

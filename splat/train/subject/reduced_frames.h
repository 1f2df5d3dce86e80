// Training frames at a fraction of their size, for the first steps of a run
// (Schedule::DownscaleAt).
#pragma once

#include <vector>

#include "splat/train/subject/subject.h"

namespace cosplat {

// The camera of a frame whose sides are divided by `downscale`.
Camera Reduced(Camera camera, int downscale);

// Divides the sides of a frame by `downscale`: averages blocks of pixels, weighted by alpha if
// present. Leftover pixels at the right and the bottom are cropped, so that the camera is exact. A
// block with an ignored pixel is ignored.
TrainFrame Reduced(const TrainFrame& frame, int downscale);

// The reduced frames of a subject, which must outlive this object. Keeps those of the last
// downscale requested, as many as the subject allows.
class ReducedFrames {
 public:
  explicit ReducedFrames(const Subject& subject) : subject_(subject) {}

  // Frame i; the subject's own if downscale is 1, valid as long as that; else until the
  // next call. Throws Error if its image does not have its camera's size.
  const TrainFrame& At(size_t i, int downscale);
  size_t allocated_bytes() const { return bytes_; }  // bytes

 private:
  const Subject& subject_;
  int downscale_ = 1;
  std::vector<TrainFrame> reduced_;  // [frames] empty image: not computed, or not kept
  TrainFrame passing_;
  size_t of_passing_ = size_t(-1);
  size_t bytes_ = 0;
};

}  // namespace cosplat

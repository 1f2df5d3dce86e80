// A view of random Gaussians whose cost is known: what the training step is timed on.
//
// MakeSyntheticView -> Gaussians + one image of them -> StepTimer
// (apps/study/bench/step_timer.h).
#pragma once

#include "splat/gaussians.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct SyntheticView {
  Gaussians start;   // what is trained: the photographed ones, displaced
  TrainFrame frame;  // the image
};

// `count` Gaussians of degree 3 (at least 1) spread evenly over an image of this size. Their size
// falls with their number so that together they cover kSyntheticLayers times the image's area
// whatever the count, up to a million on 512x512: below that the renderer's low-pass filter is
// larger than they may be. The same seed gives the same bits.
constexpr double kSyntheticLayers = 48;
SyntheticView MakeSyntheticView(size_t count, int width, int height, uint64_t seed);

// A view as a trained scene gives it: kTrainedPerPixel Gaussians of degree 3 per pixel, with the
// shapes and opacities that training leaves, many of them needles thinner than a pixel.
constexpr double kTrainedPerPixel = 0.2425;  // a chair at 800x800, 30,000 steps: 155,179
SyntheticView MakeTrainedView(int width, int height, uint64_t seed);

}  // namespace cosplat

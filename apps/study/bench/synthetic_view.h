// A view of random Gaussians with known cost, on which training steps are timed.
//
// MakeSyntheticView -> Gaussians + one image of them -> StepTimer
// (apps/study/bench/step_timer.h).
#pragma once

#include "splat/gaussians.h"
#include "splat/train/trainer.h"

namespace cosplat {

struct SyntheticView {
  Gaussians start;   // what is trained: the rendered Gaussians, displaced
  TrainFrame frame;  // the image
};

// `count` Gaussians of degree 3 (at least 1) spread evenly over an image of this size. Their size
// decreases with their number, so that together they cover kSyntheticLayers times the image's area
// for any count up to a million at 512x512; beyond that, they would have to be smaller than the
// renderer's low-pass filter. The same seed gives the same bits.
constexpr double kSyntheticLayers = 48;
SyntheticView MakeSyntheticView(size_t count, int width, int height, uint64_t seed);

// A view with the statistics of a trained scene: kTrainedPerPixel Gaussians of degree 3 per pixel,
// with the shapes and opacities that training produces, many of them needle-like (highly
// anisotropic) and thinner than a pixel.
constexpr double kTrainedPerPixel = 0.2425;  // a chair at 800x800, 30,000 steps: 155,179
SyntheticView MakeTrainedView(int width, int height, uint64_t seed);

}  // namespace cosplat

// A step as it is planned, and what its views are drawn in.
#pragma once

#include <cstddef>
#include <memory>

#include "splat/render/rasterizer.h"
#include "splat/train/loss/crop_loss.h"
#include "splat/train/optimize/optimizer.h"

namespace cosplat {

// A step of one view, or one view of a step.
struct StepPlan {
  int iteration = 0;  // of this step, from 1
  size_t frame = 0;   // index of the subject's frame
  RenderSettings render;
  AdamSettings rates;
  bool gathers_statistics = false;  // for density control
  int downscale = 1;                // factor that the sides of its image are divided by
  Crop crop;                        // for the crop loss; the engine draws it
  float exposure_rate = 0;          // of Adam on the frame's exposure
  float color_curvature = 0;        // weight of ColorCurvatureBackward (kernels/step.h)
};

// What drawing a view and its backward pass leave, in the stream's memory; reused between steps.
struct Drawing {
  WorldGaussians world;
  RenderedImage image;
  std::unique_ptr<RenderTape> tape;
  Gaussians gradients;   // of several views, of a part of the Gaussians at a time
  Buffer<float> screen;  // [N, 2] gradients of the centres
};

}  // namespace cosplat

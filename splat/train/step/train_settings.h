// Settings of a training run (splat/train/trainer.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "splat/train/density/density.h"
#include "splat/train/loss/crop_loss.h"
#include "splat/train/loss/loss.h"
#include "splat/train/optimize/optimizer.h"
#include "splat/train/optimize/schedule.h"
#include "splat/train/prune/pruner.h"

namespace cosplat {

// Which Gaussians Adam updates in a step: all, as in 3DGS, or only groups in which one has a
// gradient, while momentum updates of the others are deferred until they have one again (lazy Adam;
// splat/train/optimize/optimizer.h, docs/performance.md).
enum class AdamOn { kAll, kDrawn };

enum class Background { kBlack, kWhite, kRandom };

// Learning rates of 3DGS (Kerbl et al. 2023, released code) unless stated otherwise.
struct LearningRates {
  float position_lr_init = 1.6e-4f;  // times the subject's extent
  float position_lr_final = 1.6e-6f;
  float color = 2.5e-3f;
  std::optional<float> rest;  // of the coefficients of bands >= 1; none: color / 20 (3DGS)
  float opacity = 0.05f;
  float scale = 5e-3f;
  float rotation = 1e-3f;
  float correction = 3e-4f;  // of avatars, in the units of avatar/math/correct.h; it falls
  float exposure = 0.02f;    // of a training frame; it falls

  float RestRate() const { return rest.value_or(color / 20); }
};

// Penalises large needle-like (high-anisotropy) Gaussians: mean of the largest standard deviation
// over those Gaussians that are both larger than `limit` and more than `ratio` times longer than
// wide (SplattingAvatar).
struct ScaleRegularizer {
  float weight = 0;
  float limit = 0.008f;  // scene units
  float ratio = 10;
};

// Steps between updates of the 3D smoothing filter (Mip-Splatting's released code).
constexpr int kSmoothingEvery = 100;

constexpr size_t kFewViews = 25;

struct TrainSettings {
  int iterations = 30000;  // views trained on
  // Those of an earlier training of the first Gaussians, where the schedule goes on.
  int first_iteration = 0;
  // Views of a step, of scenes. Rates follow (math/adam.h); what the schedule plans for an
  // iteration happens after the step that it is in.
  int batch = 1;
  int degree = 3;        // highest band trained
  int first_degree = 0;  // highest band at step 0; one more per Schedule::degree_every
  uint64_t seed = 0;
  Background background = Background::kBlack;
  LossWeights loss;
  float late_mse = 0;  // is added to the loss' weight of the squared error after density control
  // Weight of half the mean square, over all directions, of the Laplacian of visible Gaussians'
  // colours, beside one of an image's values: a few views say little of how colours depend on
  // direction. In full up to kFewViews training views, not at all from twice as many on.
  float color_curvature = 0;
  CropLossSettings crop_loss;
  ScaleRegularizer scale_regularizer;
  LearningRates rates;
  std::array<float, kAttributeCount> eps = kAttributeEps;
  Schedule schedule;
  DensitySettings density;
  PruneSettings prune;
  float drop_bands =
      0;  // threshold of DropBandsInTraining (splat/train/density/bands.h); 0: keep all
  AdamOn adam_on = AdamOn::kDrawn;
  // Trains Gaussians::antialiased and, where the subject is static, Gaussians::smoothing, which is
  // found again from the positions after every kSmoothingEvery steps.
  bool antialiasing = false;
  // Trains an exposure of every frame (splat/train/loss/photograph.h).
  bool exposure = false;
  int exp_degree = kMaxExpDegree;  // of the blend loop's exponential (splat/config.h)

  // Of a step, whose loss is a mean over `values` of an image.
  float ColorCurvatureOf(size_t training_views, size_t values) const {
    const float share = 2 - float(training_views) / kFewViews;
    return color_curvature * std::clamp(share, 0.0f, 1.0f) / float(values);
  }
  LossWeights LossAt(int iteration) const {
    LossWeights weights = loss;
    if (iteration > schedule.densify_until) weights.mse += late_mse;
    return weights;
  }
};

}  // namespace cosplat

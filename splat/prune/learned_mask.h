// A number per Gaussian that is trained beside it, from which a rule makes its mask
// (splat/train/kernels/prune_mask.h).
#pragma once

#include <vector>

#include "splat/device/buffer.h"
#include "splat/math/adam.h"
#include "splat/train/kernels/prune_mask.h"

namespace cosplat {

struct LearnedMask {
  LearnedMask(size_t gaussians, float first, float rate)
      : rate(rate), value(gaussians, first), m(gaussians, 0.0f), v(gaussians, 0.0f) {}

  size_t size() const { return value.size(); }
  size_t Held() const { return HeldBy(value, m, v); }
  float operator[](size_t i) const { return value[i]; }

  float rate;
  std::vector<float> value, m, v;  // [N] and its moments
  int64_t step = 0;                // that were taken
};

// A mask that is learned in every step, by MaskLearner (splat/train/mask_learner.h); what it has
// learned is back here when a round of pruning ranks.
struct MaskInSteps {
  MaskKind kind = MaskKind::kHard;
  float weight = 0;                          // of its mean in the loss
  LearnedMask* learned = nullptr;            // null: nothing is learned now
  std::vector<float>* importance = nullptr;  // [N] where the mask is soft
};

}  // namespace cosplat

// A trained value per Gaussian from which a pruning rule derives its mask
// (splat/train/prune/kernels/prune_mask.h).
#pragma once

#include <string>
#include <vector>

#include "splat/base/state_file.h"
#include "splat/device/arrays.h"
#include "splat/math/adam.h"
#include "splat/train/prune/kernels/prune_mask.h"

namespace cosplat {

struct LearnedMask {
  LearnedMask(size_t gaussians, float first, float rate)
      : rate(rate), value(gaussians, first), m(gaussians, 0.0f), v(gaussians, 0.0f) {}

  // As in splat/device/arrays.h.
  template <class Visit, class... Of>
  static void ForEachArray(const Visit& visit, Of&... of) {
    visit("value", size_t(1), of.value...);
    visit("m", size_t(1), of.m...);
    visit("v", size_t(1), of.v...);
  }

  size_t size() const { return value.size(); }
  // Writes it to a checkpoint under this name or reads it, for `count` Gaussians.
  void Serialize(StateArchive& archive, const std::string& name, size_t count) {
    ForEachArray(
        [&](const std::string& array, size_t, auto& numbers) {
          archive.Array(name + "." + array, numbers, count);
        },
        *this);
    archive.Value(name + ".step", step);
  }
  size_t allocated_bytes() const { return AllocatedByArrays(*this); }
  float operator[](size_t i) const { return value[i]; }

  float rate;
  Buffer<float> value, m, v;  // [N] value and Adam moments
  int64_t step = 0;           // Adam steps taken
};

// A mask that MaskLearner (splat/train/prune/mask_learner.h) trains in every step. Its values are
// written back to `learned` before a pruning round ranks.
struct MaskInSteps {
  MaskKind kind = MaskKind::kHard;
  float weight = 0;                          // weight of the mask's mean in the loss
  LearnedMask* learned = nullptr;            // null: nothing is currently learned
  std::vector<float>* importance = nullptr;  // [N] for a soft mask
};

}  // namespace cosplat

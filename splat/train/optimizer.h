// Adam over the Gaussians' attributes, each with its own rate.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/gaussians.h"
#include "splat/math/adam.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

struct AdamSettings {
  std::array<float, kAttributeCount> rate{};
  std::array<float, kAttributeCount> eps{1e-15f, 1e-15f, 1e-15f, 1e-15f, 1e-15f, 1e-15f};  // 3DGS
};

// The constants of step `step`, counted from 1, for one attribute.
math::AdamStep StepOf(const AdamSettings& settings, int attribute, int64_t step);

// Gaussians are updated in groups of kGaussianGroup: their numbers fill whole SIMD registers.
inline size_t AdamGroupCount(size_t gaussians) {
  return (gaussians + kGaussianGroup - 1) / kGaussianGroup;
}

// First and second moments, laid out as the Gaussians they belong to.
struct AdamState {
  AdamState() = default;
  // Zero, for these Gaussians.
  explicit AdamState(const Gaussians& gaussians);

  Gaussians m;
  Gaussians v;
  int64_t step = 0;
  std::vector<int64_t> updated;  // [groups] the step that each was last brought to
};

// One step on the Gaussians of `groups` (ascending). The others have no gradient. What the step
// would do to them (their values go on by their momentum, their moments shrink) is put off until
// they are in `groups` again, and then done at once (math/adam.h): the optimiser reads and writes
// only what a view draws. `position_rate_scale` ([N, 3] or empty) multiplies the rate of each
// component of kPosition. Non-finite gradients count as zero; returns how many there were.
size_t AdamStepAll(const AdamSettings& settings,
                   const Gaussians& gradients,
                   View<const float> position_rate_scale,
                   View<const uint32_t> groups,
                   Gaussians& values,
                   AdamState& state);

// Does what was put off, for all Gaussians. Needed before they are reordered, judged or saved (in
// the middle of a run on a copy: Trainer::CaughtUp).
void AdamCatchUpAll(const AdamSettings& settings,
                    View<const float> position_rate_scale,
                    Gaussians& values,
                    AdamState& state);

}  // namespace cosplat

// Adam over the Gaussians' attributes, each with its own learning rate.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/gaussians.h"
#include "splat/math/adam.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

constexpr auto kAttributeEps = [] {
  std::array<float, kAttributeCount> eps{};
  eps.fill(float(math::kAdamEps));
  return eps;
}();

struct AdamSettings {
  std::array<float, kAttributeCount> rate{};
  std::array<float, kAttributeCount> eps = kAttributeEps;
  int batch = 1;  // views of a step (math/adam.h)
};

// Gaussians are updated in groups of kGaussianGroup, whose values fill whole SIMD registers.
inline size_t AdamGroupCount(size_t gaussians) {
  return (gaussians + kGaussianGroup - 1) / kGaussianGroup;
}

// First and second moments, laid out like the Gaussians they belong to and in the same memory.
struct AdamState {
  AdamState() = default;
  // Zero moments for these Gaussians, on the host.
  explicit AdamState(const Gaussians& gaussians);

  Gaussians m;
  Gaussians v;
  uint32_t step = 0;
  Buffer<uint32_t> updated;  // [groups] step up to which each group has been updated
  Buffer<uint32_t> ignored;  // [1] number of non-finite gradients so far
  Buffer<uint32_t> behind;   // [groups] what the last of the functions below did (kernels/adam.h)

  // Same as those of Gaussians (splat/gaussians.h). Not `behind`, which each step finds anew.
  void Upload(const AdamState& from, Stream& stream);
  void Download(AdamState& to, Stream& stream) const;
};

// One Adam step on the groups with a Gaussian i whose moves[i] > 0 (its radius in the view), or on
// all groups if `update_mask` is empty. The other groups have no gradient: what the step would do
// to them (values move on by momentum, moments decay) is deferred until they have one again and
// then applied at once (lazy Adam; math/adam.h), so that the optimiser reads and writes only what
// is visible in a view. `position_rate_scale` ([N, 3] or empty) multiplies the learning rate of
// each component of kPosition. Non-finite gradients count as zero and are counted in state.ignored.
// If `overflowed` is given and *overflowed is not 0, only `step` changes.
void AdamStepAll(const AdamSettings& settings,
                 const Gaussians& gradients,
                 View<const float> position_rate_scale,
                 View<const float> update_mask,
                 Gaussians& values,
                 AdamState& state,
                 Stream& stream = HostStream(),
                 const uint32_t* overflowed = nullptr);

// Catch-up: applies the deferred updates of all Gaussians. Needed before they are reordered,
// evaluated or saved (in the middle of a run on a copy: Trainer::CaughtUp).
void AdamCatchUpAll(const AdamSettings& settings,
                    View<const float> position_rate_scale,
                    Gaussians& values,
                    AdamState& state,
                    Stream& stream = HostStream());

}  // namespace cosplat

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

// Gaussians are updated in groups of kGaussianGroup: their numbers fill whole SIMD registers.
inline size_t AdamGroupCount(size_t gaussians) {
  return (gaussians + kGaussianGroup - 1) / kGaussianGroup;
}

// First and second moments, laid out as the Gaussians they belong to and in the same memory.
struct AdamState {
  AdamState() = default;
  // Zero, for these Gaussians, on the host.
  explicit AdamState(const Gaussians& gaussians);

  Gaussians m;
  Gaussians v;
  uint32_t step = 0;
  Buffer<uint32_t> updated;  // [groups] the step that each was last brought to
  Buffer<uint32_t> ignored;  // [1] gradients so far that were not finite
  Buffer<uint32_t> behind;   // [groups] scratch of the functions below

  // As Gaussians' (splat/gaussians.h).
  void Upload(const AdamState& from, Stream& stream);
  void Download(AdamState& to, Stream& stream) const;
};

// One step on the groups with a Gaussian i whose moves[i] > 0 (a radius, as it was drawn), or on
// all where `moves` is empty. The others have no gradient. What the step would do to them (their
// values go on by their momentum, their moments shrink) is put off until they move again, and then
// done at once (lazy Adam; math/adam.h): the optimiser reads and writes only what a view draws.
// `position_rate_scale` ([N, 3] or empty) multiplies the rate of each component of kPosition.
// Non-finite gradients count as zero, and in state.ignored. Where *overflowed (or null) is not 0,
// only `step` changes.
void AdamStepAll(const AdamSettings& settings,
                 const Gaussians& gradients,
                 View<const float> position_rate_scale,
                 View<const float> moves,
                 Gaussians& values,
                 AdamState& state,
                 Stream& stream = HostStream(),
                 const uint32_t* overflowed = nullptr);

// Does what was put off, for all Gaussians. Needed before they are reordered, judged or saved (in
// the middle of a run on a copy: Trainer::CaughtUp).
void AdamCatchUpAll(const AdamSettings& settings,
                    View<const float> position_rate_scale,
                    Gaussians& values,
                    AdamState& state,
                    Stream& stream = HostStream());

}  // namespace cosplat

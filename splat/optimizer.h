// Adam over the Gaussians' attributes, each with its own rate.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

struct AdamSettings {
  std::array<float, kAttributeCount> rate{};
  std::array<float, kAttributeCount> eps{1e-15f, 1e-15f, 1e-15f, 1e-15f, 1e-15f, 1e-15f};  // 3DGS
};

// First and second moments, laid out as the Gaussians they belong to.
struct AdamState {
  Gaussians m;
  Gaussians v;
  int64_t step = 0;
};

// Gaussians begin, begin + 1, ... end - 1: what one thread takes at a time.
struct GaussianRange {
  uint32_t begin, end;
};
constexpr size_t kLongestGaussianRange = 512;

// One step on every number of the Gaussians in `ranges` (which do not overlap); the others keep
// their values and their moments. `position_rate_scale` ([N, 3] or empty) multiplies the rate of
// each component of kPosition. Non-finite gradients count as zero; returns how many there were.
size_t AdamStepAll(const AdamSettings& settings,
                   const Gaussians& gradients,
                   View<const float> position_rate_scale,
                   View<const GaussianRange> ranges,
                   Gaussians& values,
                   AdamState& state);

// All n Gaussians, in ranges of at most kLongestGaussianRange.
std::vector<GaussianRange> AllRanges(size_t n);

}  // namespace cosplat

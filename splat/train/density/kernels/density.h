// Density control, one Gaussian at a time: offsets of split Gaussians, removal. Shared by both back
// ends. Source: Kerbl et al. 2023, section 5.
#pragma once

#include <cmath>
#include <cstdint>

#include "splat/base/rng.h"
#include "splat/math/quat.h"

namespace cosplat::math {

constexpr float kSplitShrink = 1.6f;  // 3DGS: children's scale is the parent's over 0.8 * N, N = 2
constexpr float kResetOpacity = 0.01f;  // 3DGS

COSPLAT_HD float LargestScale(const float* scale_log) {
  float largest = scale_log[0];
  for (int k = 1; k < 3; ++k)
    if (largest < scale_log[k]) largest = scale_log[k];
  return std::exp(largest);
}

// A sample from the Gaussian itself, relative to its centre.
COSPLAT_HD Vec3<float> SplitOffset(const float* rotation, const float* scale_log, Rng& rng) {
  const Vec3<float> local{rng.Normal() * std::exp(scale_log[0]),
                          rng.Normal() * std::exp(scale_log[1]),
                          rng.Normal() * std::exp(scale_log[2])};
  return RotationOf(Normalize(Quat<float>{rotation[0], rotation[1], rotation[2], rotation[3]})) *
         local;
}
constexpr uint64_t kSplitDraws = 6;  // random numbers that SplitOffset takes

// Long-axis split (Deng et al. 2025, arXiv:2508.12313): a Gaussian is cut in two across its longest
// axis. The halves are kCutOffset standard deviations from its centre, to both sides, and have
// these shares of its length, its other axes and its opacity.
constexpr float kCutOffset = 1.5f, kCutLength = 0.5f, kCutWidth = 0.85f, kCutOpacity = 0.6f;

COSPLAT_HD int LongestAxis(const float* scale_log) {
  int longest = 0;
  for (int k = 1; k < 3; ++k)
    if (scale_log[longest] < scale_log[k]) longest = k;
  return longest;
}

// A half's centre relative to the whole's. side: -1 or 1.
COSPLAT_HD Vec3<float> HalfOffset(const float* rotation, const float* scale_log, float side) {
  const int axis = LongestAxis(scale_log);
  const float offset = side * kCutOffset * std::exp(scale_log[axis]);
  const Vec3<float> local{axis == 0 ? offset : 0, axis == 1 ? offset : 0, axis == 2 ? offset : 0};
  return RotationOf(Normalize(Quat<float>{rotation[0], rotation[1], rotation[2], rotation[3]})) *
         local;
}

// Makes a whole's scales and opacity a half's.
COSPLAT_HD void CutInHalf(float* scale_log, float& opacity_logit) {
  const int axis = LongestAxis(scale_log);
  for (int k = 0; k < 3; ++k) scale_log[k] += std::log(k == axis ? kCutLength : kCutWidth);
  // a' = s a  =>  e^l' = a' / (1 - a') = s / (1 - s + e^-l) = s e^l / (1 + (1 - s) e^l)
  constexpr float s = kCutOpacity;
  opacity_logit = opacity_logit > 0 ? std::log(s) - std::log(1 - s + std::exp(-opacity_logit))
                                    : std::log(s) + opacity_logit -
                                          std::log(1 + (1 - s) * std::exp(opacity_logit));
}

// Logit of the opacity a' that two copies in one place need to be as opaque as one of opacity a:
// 1 - a = (1 - a')^2 (Rota Bulo et al. 2024, section 3.3). With a = sigmoid(l):
//   e^l' = a' / (1 - a') = sqrt(1 + e^l) - 1, written so that nothing overflows or cancels.
COSPLAT_HD float SharedOpacityLogit(float logit) {
  if (logit > 0)
    return 0.5f * logit - std::log(std::sqrt(1 + std::exp(-logit)) + std::exp(-0.5f * logit));
  return logit - std::log(std::sqrt(1 + std::exp(logit)) + 1);
}

// Which Gaussians are removed for their opacity or size. There is no limit in pixels: 3DGS has one
// that its code never applies, and applying it costs accuracy (docs/reference.md).
struct RemovalRule {
  float min_logit;
  bool removes_oversized;
  float max_scale;
};
enum class Removal { kNone, kTransparent, kOversized };
COSPLAT_HD Removal RemovalOf(const RemovalRule& rule, float opacity_logit, const float* scale_log) {
  if (opacity_logit < rule.min_logit) return Removal::kTransparent;
  if (rule.removes_oversized && LargestScale(scale_log) > rule.max_scale)
    return Removal::kOversized;
  return Removal::kNone;
}

}  // namespace cosplat::math

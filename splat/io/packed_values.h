// What the readers of packed splat files have in common: how a byte stands for an opacity, a colour
// or a rotation, and what a file of so many bytes may claim to hold.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "splat/basis_constants.h"
#include "splat/gaussians.h"

namespace cosplat {

constexpr double kSqrtHalf = 0.70710678118654752;

// The constant colour's coefficient of a colour in 0..1.
inline float DcOfColor(double color) {
  return float((color - 0.5) / BasisConstants(Basis::kSh)[0]);
}

// The logit of an opacity that was stored in a byte. 0 and 1 have no finite logit; they are moved
// by a quarter of 1/255, to the middle of the values that round to them, so that 0 stays below the
// smallest alpha that is rendered.
inline float LogitOfByteShare(double share) {
  constexpr double kQuarter = 0.25 / 255;
  const double opacity = std::clamp(share, kQuarter, 1 - kQuarter);
  return float(std::log(opacity / (1 - opacity)));
}
// opacity_logit -> 0..255.
inline uint8_t ByteOfLogit(float logit) {
  return uint8_t(std::lround(255 / (1 + std::exp(-double(logit)))));
}

// The component of a unit quaternion that its other three leave.
inline double LargestOf(double sum_of_squares) {
  return std::sqrt(std::max(0.0, 1 - sum_of_squares));
}

// The quaternion's components divided by its norm, signs chosen so that the largest in magnitude,
// whose index is returned, is positive. `q` of zero norm becomes the identity of wxyz.
int NormalizeByLargest(std::array<double, 4>& q);

// What files with at most three bands can hold. Throws Error naming `path` if the basis is not
// kSh, if the degree is above kMaxSplatFileDegree, for a value that is not finite (naming the
// Gaussian), and if there are no Gaussians.
void CheckForSplatFile(const std::string& path, const Gaussians& gaussians);

// Throws Error naming path and field for more splats than a file of this size plausibly holds.
// Packed splats take 8 bytes and more, but equal ones deflate to nothing: without a limit a file of
// a megabyte could ask for a terabyte.
void CheckSplatCount(const std::string& path,
                     const std::string& field,
                     uint64_t count,
                     uint64_t file_bytes);

}  // namespace cosplat

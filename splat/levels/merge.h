// One Gaussian in place of two: the same mean and covariance as the two together, weighted by how
// much of an image they cover, and as much coverage, unless it would be more opaque than kMaxAlpha.
// Source: Kerbl et al. 2024 (hierarchical
// 3DGS), section 4.1. Not differentiated: nothing is trained through it.
#pragma once

#include <cstddef>

#include "splat/gaussians.h"

namespace cosplat {

// The arrays of one Gaussian: pointers to its values by Attribute.
template <class Float>
struct OneGaussian {
  Float* values[kAttributeCount] = {};
};

// Opacity times the mean area of its shadow: how much of an image it covers, world units^2.
double Coverage(const OneGaussian<const float>& g);

struct Merged {
  double share;  // of the second in the sum
  double lost;   // world units^2: mean square distance of the two means from theirs, by coverage
};

// `widths`: floats by Attribute; there are no corrections.
Merged MergeTwo(const OneGaussian<const float>& a,
                const OneGaussian<const float>& b,
                const size_t (&widths)[kAttributeCount],
                const OneGaussian<float>& out);

}  // namespace cosplat

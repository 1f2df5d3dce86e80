// One Gaussian in place of two: the same mean and covariance as the two together, weighted by how
// much of the image they cover, and as much coverage. Source: Kerbl et al. 2024 (hierarchical
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

// `widths`: floats by Attribute; there are no corrections. Returns the squared distance between the
// means' mean and the two, weighted as they are: what merging loses, world units^2.
double MergeTwo(const OneGaussian<const float>& a,
                const OneGaussian<const float>& b,
                const size_t (&widths)[kAttributeCount],
                const OneGaussian<float>& out);

}  // namespace cosplat

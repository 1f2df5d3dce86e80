// Vector quantisation of colours: the least significant splats share the bands of a codebook.
//
// Gaussians, significance -> Quantise -> QuantisedSplats -> splat/io/vq_file.h. Each splat keeps
// its constant colour; bands 1 and up are quantised. 3DGS's SH is orthonormal, so the distance of
// two rows of coefficients is the distance of the colours over the sphere. Source: LightGaussian
// (Fan et al. 2024), which also quantises the constant colour: that saves 6 bytes per splat, but
// costs more in quality than it is worth (docs/vq-file.md).
#pragma once

#include "splat/gaussians.h"
#include "splat/io/significance.h"
#include "splat/io/vq_file.h"

namespace cosplat {

struct VqSettings {
  int codebook = 8192;  // maximum rows per degree in use; 1 to 65536
  double keep = 0.4;    // fraction of splats, the most significant, with their own bands
  uint64_t seed = 0;
};

// gaussians: in 3DGS's SH (throws Error otherwise). significance: [N] >= 0; non-finite values count
// as 0. Rotations are normalised; a quaternion of zero norm becomes the identity.
QuantisedSplats Quantise(const Gaussians& gaussians,
                         View<const float> significance,
                         const VqSettings& settings);

}  // namespace cosplat

// Vector quantisation of colours: the splats that matter least share the bands of a codebook.
//
// Gaussians, significance -> Quantise -> QuantisedSplats -> splat/io/vq_file.h. Each splat keeps
// its constant colour; bands 1 and up are quantised. In 3DGS's SH, which is orthonormal, the
// distance of two rows of coefficients is that of the colours over the sphere. Source:
// LightGaussian (Fan et al. 2024), which quantises the constant colour with them: 6 bytes less a
// splat, for more than they are worth (docs/vq-file.md).
#pragma once

#include "splat/gaussians.h"
#include "splat/io/vq_file.h"

namespace cosplat {

struct VqSettings {
  int codebook = 8192;  // rows at most, per degree in use; 1 to 65536
  double keep = 0.4;    // share of the splats, the most significant ones, with bands of their own
  uint64_t seed = 0;
};

// gaussians: in 3DGS's SH (Error otherwise). significance: [N] >= 0; one that is not finite counts
// as 0. Rotations become unit; one without a direction the identity.
QuantisedSplats Quantise(const Gaussians& gaussians,
                         View<const float> significance,
                         const VqSettings& settings);

// Opacity times the geometric mean of the standard deviations: what stands in for significance
// where no view is known.
std::vector<float> SizeSignificance(const Gaussians& gaussians);

}  // namespace cosplat

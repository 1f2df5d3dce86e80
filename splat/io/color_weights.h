// What an error in a Gaussian's colour weighs when files are compressed (splat/io/sog.h, spz.h).
//
// SeenBands: which way the colour leans over the directions from which it is seen, which lets a
// file that stores bands 1 and up coarsely put the mean of their error into the constant colour.
// Gaussians, cameras -> SeenBands -> WriteSog, WriteSpz -> MoveErrorToDc. On garden (249,515
// Gaussians, docs/files.md) this regains two fifths of what coarse bands lose, at no cost in bytes.
#pragma once

#include <vector>

#include "splat/base/camera.h"
#include "splat/gaussians.h"

namespace cosplat {

// [N, (degree+1)^2 - 1]: the mean of each basis function of bands 1 and up over the directions from
// the cameras whose images show the Gaussian's centre, weighted by its area there (1 / depth^2).
// Zero where no camera does. gaussians: in 3DGS's SH, with positions in the world.
std::vector<float> SeenBands(const Gaussians& gaussians, const std::vector<Camera>& cameras);

// Adds to the constant colour what `stored` bands, [(degree+1)^2 - 1, 3], lack of the true ones in
// the mean over the directions seen. bands: of one Gaussian, [(degree+1)^2 - 1, 3]; seen: its row
// of SeenBands.
void MoveErrorToDc(
    const float* bands, const float* stored, const float* seen, int degree, float* dc);

// Opacity times the geometric mean of the standard deviations: a substitute for significance
// (splat/train/prune/importance.h) if no views are known. [N]
std::vector<float> SizeSignificance(const Gaussians& gaussians);

// [N] > 0: the weight of each Gaussian in k-means, its significance kept above 1e-4 of the mean.
// One that is not finite, as of a splat larger than any float, counts as 0. Over equal weights a
// SOG of the fox of docs/dcsh.md gains 0.20 dB by this (32.12 to 32.32 dB), one of its chair 0.07
// dB.
std::vector<float> WeightsOf(View<const float> significance);

}  // namespace cosplat

// Runs the element-wise kernels (splat/kernels) over oneTBB, compiled per instruction set.
#pragma once

#include "splat/cpu/tile_lists.h"
#include "splat/kernels/world_gaussians.h"

namespace cosplat {

void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats);

// Sums each drawn Gaussian's records in their order, then applies the projection's derivative.
// Records of entries beyond a tile's stop must be zero.
void LaunchProjectVjp(const WorldGaussians& gaussians,
                      const ViewParameters& view,
                      const ProjectedSplat* splats,
                      const SplatGradient* d_splats,
                      const WorldGradients& gradients);

}  // namespace cosplat

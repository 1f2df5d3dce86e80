// Runs the element-wise kernels (splat/kernels) over oneTBB, compiled per instruction set.
#pragma once

#include "splat/cpu/tile_lists.h"
#include "splat/kernels/world_gaussians.h"

namespace cosplat {

void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats);

// d_splats: [count], read only where a Gaussian was drawn. Writes every gradient.
void LaunchProjectVjp(const WorldGaussians& gaussians,
                      const ViewParameters& view,
                      const ProjectedSplat* splats,
                      const SplatGradient* d_splats,
                      const WorldGradients& gradients);

}  // namespace cosplat

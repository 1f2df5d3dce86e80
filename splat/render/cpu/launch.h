// Runs the element-wise kernels (splat/render/kernels) over oneTBB, compiled per instruction set.
#pragma once

#include "splat/render/cpu/tile_lists.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

// Writes radii of all Gaussians, and the splats of those that are drawn.
void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats,
                   float* radii);

// d_splats: [count], counts only where a Gaussian was drawn. Writes the gradients: see
// Rasterizer::Backward (splat/render/rasterizer.h).
void LaunchProjectVjp(const WorldGaussians& gaussians,
                      const ViewParameters& view,
                      const ProjectedSplat* splats,
                      const float* radii,
                      const SplatGradient* d_splats,
                      const WorldGradients& gradients);

}  // namespace cosplat

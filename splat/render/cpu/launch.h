// Runs the element-wise kernels (splat/render/kernels/) in parallel with oneTBB, compiled once per
// instruction set.
#pragma once

#include "splat/render/cpu/tile_lists.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

// Writes the radii of all Gaussians and the projected splats of the visible ones.
void LaunchProject(const WorldGaussians& gaussians,
                   const ViewParameters& view,
                   ProjectedSplat* splats,
                   float* radii);

// d_splats: [count], used only where radii > 0. Writes the gradients as specified by
// Rasterizer::Backward (splat/render/rasterizer.h).
void LaunchProjectVjp(const WorldGaussians& gaussians,
                      const ViewParameters& view,
                      const ProjectedSplat* splats,
                      const float* radii,
                      const SplatGradient* d_splats,
                      const WorldGradients& gradients);

// The same for Gaussians [begin, end) that are anti-aliased; begin: a multiple of kGaussianGroup.
void ProjectAntialiased(const WorldGaussians& gaussians,
                        const ViewParameters& view,
                        ProjectedSplat* splats,
                        float* radii,
                        size_t begin,
                        size_t end);
void ProjectAntialiasedVjp(const WorldGaussians& gaussians,
                           const ViewParameters& view,
                           const ProjectedSplat* splats,
                           const float* radii,
                           const SplatGradient* d_splats,
                           const WorldGradients& gradients,
                           size_t begin,
                           size_t end);

}  // namespace cosplat

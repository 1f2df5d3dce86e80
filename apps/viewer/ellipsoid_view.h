// Gaussians as the surfaces at one standard deviation, lit, each in its mean colour: shows where
// they are and how they lie, which their soft blend hides.
#pragma once

#include <array>

#include "apps/viewer/surface_buffer.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat::viewer {

// Left out: those fainter than a tenth, which the blend hardly shows, those that are not finite,
// and those that reach behind the camera.
void DrawEllipsoids(const WorldGaussians& gaussians, const Camera& camera, SurfaceBuffer& buffer);

}  // namespace cosplat::viewer

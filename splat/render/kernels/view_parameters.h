// What the element-wise kernels need of a camera, and what both back ends refuse to draw.
#pragma once

#include "splat/base/camera.h"
#include "splat/basis.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// Colours of bands up to `degree`.
ViewParameters ViewOfCamera(const Camera& camera, Basis basis, int degree);

// Throws Error as Rasterizer::Forward says.
void CheckArguments(const WorldGaussians& gaussians,
                    const Camera& camera,
                    const RenderSettings& settings);

}  // namespace cosplat

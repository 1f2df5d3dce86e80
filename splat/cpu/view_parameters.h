// What the element-wise kernels need of a camera.
#pragma once

#include "splat/base/camera.h"
#include "splat/basis.h"
#include "splat/kernels/world_gaussians.h"

namespace cosplat {

// Colours of bands up to `degree`.
ViewParameters ViewOfCamera(const Camera& camera, Basis basis, int degree);

}  // namespace cosplat

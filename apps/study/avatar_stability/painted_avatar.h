// An avatar without training: Gaussians spread over the made head, flat on it, in the colours that
// it is painted with as seen from the front. For measurements, tests and benches.
#pragma once

#include <vector>

#include "assets/head/procedural_head.h"
#include "avatar/model/avatar_model.h"
#include "avatar/surface/surface.h"
#include "splat/base/rng.h"

namespace cosplat {

// A Gaussian at each of the points, as wide as if they were spread evenly. The same bits for the
// same points and state of `rng`.
AvatarModel PaintedAvatar(const ProceduralHead& head,
                          const std::vector<SurfacePoint>& points,
                          Rng& rng,
                          int degree = 2);

// At `count` points of SampleSurface.
AvatarModel PaintedAvatar(const ProceduralHead& head, size_t count, int degree = 2);

}  // namespace cosplat

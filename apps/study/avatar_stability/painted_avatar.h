// An untrained avatar: flat Gaussians spread over the procedural head, in its painted colours as
// seen from the front. For measurements, tests and benchmarks.
#pragma once

#include <vector>

#include "assets/head/procedural_head.h"
#include "avatar/model/avatar_model.h"
#include "avatar/surface/surface.h"
#include "splat/base/rng.h"

namespace cosplat {

// One Gaussian at each of `points`, as wide as if they were evenly spaced. Bit-identical for the
// same points and state of `rng`.
AvatarModel PaintedAvatar(const ProceduralHead& head,
                          const std::vector<SurfacePoint>& points,
                          Rng& rng,
                          int degree = 2);

// At `count` points of SampleSurface.
AvatarModel PaintedAvatar(const ProceduralHead& head, size_t count, int degree = 2);

}  // namespace cosplat

// First Gaussians of a run.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/rng.h"
#include "splat/gaussians.h"

namespace cosplat {

// One Gaussian per point: isotropic, its standard deviation the root mean square distance to the
// three nearest points; opacity 0.1; the point's colour (3DGS). points: [P, 3]; colors: [P, 3].
// Throws Error when there is no point or one is not finite.
Gaussians InitializeFromPoints(const std::vector<float>& points,
                               const std::vector<uint8_t>& colors,
                               int degree,
                               Basis basis);

// Keeps at most `most` points, evenly taken in their order.
void LimitPoints(size_t most, std::vector<float>& points, std::vector<uint8_t>& colors);

// The point closest to all optical axes, in the least-squares sense.
std::array<float, 3> FocusPoint(const std::vector<Camera>& cameras);

// Appends `count` points of random colour, uniform in the cube [-1.3, 1.3]^3 around the origin
// (3DGS, for synthetic scenes) or, when the cameras lie elsewhere, in the cube that they look into.
void RandomPoints(const std::vector<Camera>& cameras,
                  size_t count,
                  Rng& rng,
                  std::vector<float>& points,
                  std::vector<uint8_t>& colors);

}  // namespace cosplat

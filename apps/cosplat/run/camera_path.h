// Cameras that circle a subject, for images that people look at.
#pragma once

#include <array>
#include <vector>

#include "splat/base/camera.h"

namespace cosplat {

// Around what the training cameras look at, at their mean height and distance: a full turn where
// they stand all around, otherwise there and back over the angle that they cover.
std::vector<Camera> OrbitScene(const std::vector<Camera>& cameras, int frames);

// A full turn about the axis `up` through `target`, at `distance` from it and level with it;
// everything but the pose is that of `lens`. The first camera is at -z as far as `up` allows.
std::vector<Camera> OrbitTarget(const Camera& lens,
                                const std::array<float, 3>& target,
                                const std::array<float, 3>& up,
                                float distance,
                                int frames);

// There and back around `target`, `degrees` to each side of `reference`, about the axis `up`.
std::vector<Camera> SwingAround(const Camera& reference,
                                const std::array<float, 3>& target,
                                const std::array<float, 3>& up,
                                float degrees,
                                int frames);

}  // namespace cosplat

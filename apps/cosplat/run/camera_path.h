// Camera paths around a subject, for videos and previews.
#pragma once

#include <array>
#include <vector>

#include "splat/base/camera.h"

namespace cosplat {

// Orbits the point that the training cameras look at, at their mean height and distance: a full
// turn if they surround it, otherwise back and forth over the angle that they cover.
std::vector<Camera> OrbitScene(const std::vector<Camera>& cameras, int frames);

// The mean of the first `count` vertices.
std::array<float, 3> MiddleOf(const std::vector<float>& vertices, int count);

// Gone around `target` by `degrees` about the axis `up`, counterclockwise seen from above.
Camera TurnedAround(const Camera& reference,
                    const std::array<float, 3>& target,
                    const std::array<float, 3>& up,
                    float degrees);

// Back and forth around `target`, `degrees` to each side of `reference`, about the axis `up`.
std::vector<Camera> SwingAround(const Camera& reference,
                                const std::array<float, 3>& target,
                                const std::array<float, 3>& up,
                                float degrees,
                                int frames);

}  // namespace cosplat

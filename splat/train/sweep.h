// First points of a scene that comes without any: where its photographs agree.
// Source: Collins 1996, *A space-sweep approach to true multi-image matching*, a pixel at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/base/rng.h"
#include "splat/train/subject.h"

namespace cosplat {

// Appends to `points` ([P, 3], world) and `colors` ([P, 3]) what `rays` rays through random pixels
// meet. Along each ray that depth is taken at which neighbouring photographs show most nearly the
// same 3x3 pixels; rays on which no depth stands out, and pixels with an alpha below one half, give
// no point. Depths go from a fifth of the distance between a camera and what all look at to
// infinity, evenly in their inverse. The bits do not depend on the number of threads.
void SweepPoints(const std::vector<TrainFrame>& frames,
                 size_t rays,
                 Rng& rng,
                 std::vector<float>& points,
                 std::vector<uint8_t>& colors);

}  // namespace cosplat

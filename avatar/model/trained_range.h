// The range of faces in a training track: recorded in the avatar file, so that a player can bring
// what the avatar was never seen doing back to it (avatar/live/soft_range.h).
#pragma once

#include <vector>

#include "avatar/model/avatar_model.h"

namespace cosplat {

// Missing coefficients count as zero. Joints by the shorter way round.
TrainedRange RangeOf(const std::vector<FlameParams>& frames);

}  // namespace cosplat

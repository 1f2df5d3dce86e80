// Whether a tracked video's images, masks, cameras and parameters tell one story: what would train
// into something wrong without an error.
//
// TrackedVideo -> CheckTrack -> `cosplat check`, and the block before the first step of training.
#pragma once

#include <vector>

#include "flame/track.h"
#include "splat/base/skipped.h"

namespace cosplat {

// Looks at 24 frames at most, those that move most, and their neighbours: heads outside of the
// image or of the mask, or of another size than the masks'; images upside down, mirrored, of other
// moments than their parameters, or without content; expressions that the model cannot have. After
// SettleMasks. flame: as in TrackOptions. Throws Error as FlamePoser and LoadTrackedImage do.
std::vector<Finding> CheckTrack(const FlameModel& flame, const TrackedVideo& video);

// A frame's mesh: [V, 3], world units. Coefficients that the model lacks do not move it.
std::vector<float> PosedVertices(const FlameModel& flame,
                                 const TrackedVideo& video,
                                 const TrackedFrame& frame);

}  // namespace cosplat

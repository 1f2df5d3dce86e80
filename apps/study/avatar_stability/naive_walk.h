// Walking on triangles the naive way, beside Walk (avatar/surface/walk.h): the faults that are
// known of the released SplattingAvatar, from their description.
//
// - The path is met with the lines of all three edges together; parallel to one of them, that has
//   no solution, and the point stays where it is.
// - Across an edge the two triangles are taken for a parallelogram (avatar/math/released.h).
// - At a boundary the walk stops on the edge.
// - Nothing bounds its rounds: a weight that is not a number is never inside a triangle.
#pragma once

#include "avatar/surface/surface.h"

namespace cosplat {

struct NaiveWalkResult {
  SurfacePoint point;
  bool ended = true;  // false: `max_rounds` were not enough
};

// `max_rounds` stands for ever.
NaiveWalkResult WalkNaively(
    const Surface& surface, const SurfacePoint& start, float du, float dv, int max_rounds);

}  // namespace cosplat

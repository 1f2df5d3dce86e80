// Naive walking on triangles, for comparison with Walk (avatar/surface/walk.h). Reproduces the
// known faults of the released SplattingAvatar, from their description.
//
// - The path is intersected with the lines of all three edges in one system; parallel to one of
//   them it has no solution, and the point does not move.
// - Across an edge, the two triangles are treated as a parallelogram (avatar/math/released.h).
// - At a boundary, the walk stops on the edge.
// - The number of rounds is unbounded: a point with NaN weights is never inside a triangle.
#pragma once

#include "avatar/surface/surface.h"

namespace cosplat {

struct NaiveWalkResult {
  SurfacePoint point;
  bool ended = true;  // false: `max_rounds` were not enough
};

// `max_rounds` stands for an endless loop.
NaiveWalkResult WalkNaively(
    const Surface& surface, const SurfacePoint& start, float du, float dv, int max_rounds);

}  // namespace cosplat

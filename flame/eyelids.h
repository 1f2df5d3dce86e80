// Eyelids that close, as two expression coefficients.
//
// Trackers such as metrical-tracker, INSTA's and SMIRK fit two numbers for the lids besides FLAME's
// expression (FlameParams::eyelids), for blendshapes that FLAME's files do not have. The
// blendshapes here are made from the mesh: the upper lid turns down about the eyeball.
//
// LoadFlameModel -> WithEyelids -> FlamePoser; a track's lids become coefficients of its
// expression (EyelidsToExpression, flame/track.h), which range, live input and refinement treat as
// any other.
#pragma once

#include "flame/model.h"

namespace cosplat {

// Number of the blendshapes below, kept in avatar files.
constexpr int kEyelidGeometry = 1;

// `model` with two more expression directions after its own, for the subject's left and right lid:
// 0 open, 1 closed. Each moves vertices of the upper lid by the chord of a turn about the eyeball's
// centre, so far that its rim meets the lower lid's at rest. Returned unchanged if it has them.
// Throws Error if an eye is not open at rest.
FlameModel WithEyelids(FlameModel model);

// If `model` has eyelids: appends params.eyelids to the expression, after the model's other
// coefficients (missing ones become zero, further ones are dropped), and zeroes them.
void EyelidsToExpression(const FlameModel& model, FlameParams& params);
// The reverse, of an expression that the former has made.
void EyelidsFromExpression(const FlameModel& model, FlameParams& params);

}  // namespace cosplat

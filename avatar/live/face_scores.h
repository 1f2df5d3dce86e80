// A face as blendshape scores: a BlendshapeMap the other way round, for programs that take scores.
//
// FlameParams -> ScoresOf -> WriteVmcFrame (`cosplat send --to vmc://`).
#pragma once

#include "avatar/model/blendshape_map.h"
#include "flame/model.h"

namespace cosplat {

// The scores from 0 to 1, of all the map's names, from which the map makes the face that is nearest
// to the expression, jaw and eyes of `params`: least squares with bounds, by coordinate descent.
// What the map cannot show is left out; of scores that do the same, all have a share.
BlendshapeScores ScoresOf(const BlendshapeMap& map, const FlameParams& params);

}  // namespace cosplat
